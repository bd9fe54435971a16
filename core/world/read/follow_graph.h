#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/world/behaviour_spec.h"

namespace camrig::world {

/// Who follows whom. All are added first, then it is asked.
class FollowGraph {
public:
    void add(const std::string& actor, const BehaviourSpec& behaviour);
    /// "'anna' follows 'ben' follows 'anna'", when the actor follows itself, however far round. Asked of all, each
    /// actor is looked at once, as long as nobody is on a circle.
    std::optional<std::string> circle_of(const std::string& actor);

private:
    struct Turn {
        std::size_t who = 0;
        std::size_t next = 0;  ///< of those it follows
        bool is_clear = true;  ///< as far as they were looked at
    };

    std::size_t number_of(const std::string& name);
    std::string trail(const std::vector<Turn>& way) const;

    std::map<std::string, std::size_t> numbers_;
    std::vector<std::string> names_;
    std::vector<std::vector<std::size_t>> followed_;
    std::vector<bool> is_clear_;  ///< was looked at, and no way from it leads into a circle
};

}  // namespace camrig::world
