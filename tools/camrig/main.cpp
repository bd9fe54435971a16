#include <iostream>

#include "tools/camrig/cli.h"

int main(int argc, char** argv) {
    return camrig::run_cli({argv + 1, argv + argc}, {camrig::run_serve, std::cout, std::cerr});
}
