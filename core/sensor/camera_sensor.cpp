#include "core/sensor/camera_sensor.h"

namespace camrig::sensor {
namespace {

/// What automatic exposure and white balance go by: the light of the scene and the zoom may change under them.
SensorSpec without_light(SensorSpec spec) {
    spec.lux.reset();
    return spec;
}

}  // namespace

Result<void> CameraSensor::set_up(const SensorSetup& setup) {
    if (setup_ == setup) return {};
    auto made = Sensor::create(setup.spec, setup.size, setup.intrinsics);
    if (!made) return std::unexpected(made.error());
    sensor_ = std::make_shared<const Sensor>(std::move(*made));
    const bool is_same = setup_ && setup_->size == setup.size && setup_->rate == setup.rate &&
                         without_light(setup_->spec) == without_light(setup.spec);
    setup_ = setup;
    if (is_same) return {};
    const SensorSpec& spec = setup.spec;
    ++life_;
    exposure_.reset();
    balance_.reset();
    metered_ = 0.0;
    taken_.fill({});
    if (!spec.exposure_s)
        exposure_.emplace(AutoExposure::Options{.least_highlights = spec.least_highlights,
                                                .max_exposure_s = spec.longest_exposure_s(setup.rate),
                                                .flicker_hz = spec.flicker_hz},
                          last_setting_);
    if (!spec.white_balance_k) balance_.emplace(spec, AutoWhiteBalance::Options{});
    return {};
}

CameraSensor::Taken CameraSensor::next(std::int64_t sequence) const {
    const SensorSpec& spec = setup_->spec;
    return {.sequence = sequence,
            .setting = exposure_ ? exposure_->setting() : ExposureSetting{*spec.exposure_s, spec.gain_db},
            .balance = balance_ ? balance_->balance() : WhiteBalance::of_kelvin(spec, *spec.white_balance_k),
            .metered = metered_,
            .is_settled = !exposure_ || exposure_->is_locked()};
}

Result<Exposure> CameraSensor::exposure_of(const SensorSetup& setup, std::int64_t sequence, TimeNs end_ns) {
    const std::lock_guard lock(mutex_);
    if (auto good = set_up(setup); !good) return std::unexpected(good.error());
    const Taken& held = taken_[static_cast<std::uint64_t>(sequence) % taken_.size()];
    const Taken one = held.sequence == sequence ? held : next(sequence);
    Exposure made{.sensor = sensor_,
                  .shot = {.frame = sequence, .exposure_s = one.setting.exposure_s, .gain_db = one.setting.gain_db},
                  .balance = one.balance,
                  .reading = {},
                  .times = setup.spec.row_times(one.setting.exposure_s, setup.size.height, end_ns),
                  .life = life_};
    const auto& gains = one.balance.gains;
    made.reading = {
        .exposure_s = one.setting.exposure_s,
        .gain_db = one.setting.gain_db,
        .electrons_per_number = 1.0 / sensor_->numbers_per_e(one.setting.gain_db),
        .black_level = setup.spec.black(),
        .bits = setup.spec.bits,
        .red_gain = gains[0],
        .green_gain = gains[1],
        .blue_gain = gains[2],
        .metered = one.metered,
        .is_settled = one.is_settled,
        .exposure_start_ns = made.times.begin_ns,
        .exposure_end_ns = made.times.end_ns(),
        .row_ns = made.times.row_ns,
        .fps = setup.rate.hertz() / static_cast<double>(setup.spec.periods_of(one.setting.exposure_s, setup.rate))};
    return made;
}

double CameraSensor::longest_ahead_s(const SensorSpec& spec) {
    if (spec.exposure_s) return *spec.exposure_s;
    const std::lock_guard lock(mutex_);
    return exposure_ ? exposure_->longest_ahead_s() : last_setting_.exposure_s;
}

void CameraSensor::taken(const Exposure& exposure, const FrameStatistics& statistics) {
    const std::lock_guard lock(mutex_);
    const std::int64_t sequence = exposure.shot.frame;
    // Another spec came meanwhile, or it is an old picture.
    if (exposure.life != life_ || sequence <= last_) return;
    last_ = sequence;
    taken_[static_cast<std::uint64_t>(sequence) % taken_.size()] = {
        .sequence = sequence,
        .setting = {exposure.shot.exposure_s, exposure.shot.gain_db},
        .balance = exposure.balance,
        .metered = exposure.reading.metered,
        .is_settled = exposure.reading.is_settled};
    last_setting_ = {exposure.shot.exposure_s, exposure.shot.gain_db};
    if (exposure_) {
        exposure_->advance(statistics, exposure.balance);
        metered_ = exposure_->measured();
    }
    if (balance_) balance_->advance(statistics);
}

}  // namespace camrig::sensor
