#pragma once

#include <cstdio>
#include <string>

namespace camrig {

/// A number for a message, with six digits at most: "200", not "200.000000".
inline std::string number_text(double number) {
    char text[32];
    std::snprintf(text, sizeof text, "%.6g", number);
    return text;
}

}  // namespace camrig
