#include "core/base/image_controls.h"

#include <string>

#include "core/base/patch.h"

namespace camrig {

Result<void> check_controls(const ImageControls& controls) {
    struct Limit {
        const char* name;
        double value, low, high;
        const char* words;
    };
    for (const Limit& limit : {Limit{"exposure_ev", controls.exposure_ev, -6, 6, "-6 to 6"},
                               Limit{"gain_db", controls.gain_db, 0, 24, "0 to 24"},
                               Limit{"white_balance_k", controls.white_balance_k, 2800, 10000, "2800 to 10000"},
                               Limit{"brightness", controls.brightness, -1, 1, "-1 to 1"},
                               Limit{"contrast", controls.contrast, 0, 2, "0 to 2"},
                               Limit{"saturation", controls.saturation, 0, 2, "0 to 2"}}) {
        if (!(limit.value >= limit.low && limit.value <= limit.high))
            return error(ErrorKind::invalid_argument,
                         std::string("controls.") + limit.name + ": must be " + limit.words);
    }
    return {};
}

void apply_controls(const ImageControlsPatch& patch, ImageControls& controls) {
    assign_if(patch.auto_exposure, controls.auto_exposure);
    assign_if(patch.exposure_ev, controls.exposure_ev);
    assign_if(patch.gain_db, controls.gain_db);
    assign_if(patch.auto_white_balance, controls.auto_white_balance);
    assign_if(patch.white_balance_k, controls.white_balance_k);
    assign_if(patch.brightness, controls.brightness);
    assign_if(patch.contrast, controls.contrast);
    assign_if(patch.saturation, controls.saturation);
}

}  // namespace camrig
