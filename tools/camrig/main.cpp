#include <iostream>

#include "tools/camrig/cli.h"
#include "tools/camrig/companion_program.h"
#include "tools/camrig/rig_folder.h"
#include "v4l2_sink/preload/exec.h"

int main(int argc, char** argv) {
    const auto exec = [](const std::vector<std::string>& command, const std::string& control) {
        return camrig::device::exec_with_devices(command, camrig::cli::real_device_socket_of(control));
    };
    const auto view = [](const std::vector<std::string>& arguments) {
        return camrig::cli::exec_companion(camrig::cli::view_program, arguments);
    };
    return camrig::cli::run_cli({argv + 1, argv + argc},
                                {camrig::cli::run_serve, std::cout, std::cerr, exec, camrig::cli::exec_python, view});
}
