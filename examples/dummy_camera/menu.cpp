#include "menu.h"

#include <chrono>
#include <istream>
#include <ostream>
#include <string>

#include "moves.h"

namespace dummy {
namespace {

void print_menu(std::ostream& out) {
    out << "one command a line; letters may follow each other, as in wwj\n";
    for (const Move& move : moves()) out << "  " << move.key << "  " << move.label << "\n";
    out << "  p FILE.png   picture\n  x SECONDS    step the world (lockstep, or paused)\n  ?            this menu\n"
           "  q            end\n";
}

/// False when it is time to end.
bool obey(const camrig::client::Rig& rig, const camrig::client::Camera& camera, const std::string& line,
          std::ostream& out) {
    if (line == "q") return false;
    if (line == "?") {
        print_menu(out);
    } else if (line.rfind("p ", 0) == 0) {
        camera.snapshot(line.substr(2));
        out << "wrote " << line.substr(2) << "\n";
    } else if (line.rfind("x ", 0) == 0) {
        const std::chrono::duration<double> how_far(std::stod(line.substr(2)));
        const auto world = rig.step(std::chrono::round<std::chrono::nanoseconds>(how_far));
        out << "the world is at " << world.world_ns / 1e9 << " s\n";
    } else {
        for (const char key : line)
            if (!do_move(camera, key)) out << "no command '" << key << "'; ? lists them\n";
        out << describe(camera.get()) << "\n";
    }
    return true;
}

}  // namespace

void run_menu(const camrig::client::Rig& rig, const camrig::client::Camera& camera, std::istream& in,
              std::ostream& out) {
    print_menu(out);
    out << describe(camera.get()) << std::endl;
    for (std::string line; out << "> " << std::flush && std::getline(in, line);) {
        try {
            if (!line.empty() && !obey(rig, camera, line, out)) return;
        } catch (const std::exception& problem) {
            out << problem.what() << "\n";
        }
        out.flush();
    }
}

}  // namespace dummy
