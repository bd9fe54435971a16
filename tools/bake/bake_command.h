#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "core/bake/bake.h"

/// The options of `camrig bake`: for camrig, which explains and hands them on, and for camrig-bake, which bakes.
namespace camrig::cli {

struct BakeCommand {
    std::filesystem::path scene, out;
    bake::BakeOptions options;
    bool checks = false;  ///< says whether the light is up to date, and bakes nothing

    BakeCommand();
    void add_options(CLI::App& app);
    /// For camrig-bake.
    std::vector<std::string> words() const;
};

}  // namespace camrig::cli
