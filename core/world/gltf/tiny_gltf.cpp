// The one translation unit that holds tinygltf's code (Debian's shared library would bring stb and file access along).
#include <fstream>  // its writer needs it even without file access

#define TINYGLTF_IMPLEMENTATION
#include "core/world/gltf/tiny_gltf.h"
