#pragma once

#include <cstdint>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

#include "core/base/field_table.h"
#include "core/base/kind.h"
#include "core/base/named.h"

/// The ways in which a camera fails, each a struct of what it can be told. What a fault does at severity 1 stands in
/// its table (fault_kind.cpp); at a lower severity it does less, at 0 nothing.
namespace camrig::fault {

/// Where in a camera it happens. Faults act in this order, whatever the order in which they were set.
enum class Layer : std::uint8_t { body, optics, sensor, driver, transport };
std::span<const Named<Layer>> names_of(std::type_identity<Layer>);

// Body: where the camera looks.
struct Knock {
    static constexpr Layer layer = Layer::body;
    double pan_deg = 2.0, tilt_deg = -5.0, roll_deg = 3.0;
};
struct Sag {
    static constexpr Layer layer = Layer::body;
    double tilt_deg_per_h = -1.0;
};
struct Vibration {
    static constexpr Layer layer = Layer::body;
    double amplitude_deg = 0.2;
    double frequency_hz = 12.0;
};

// Optics: what is between the scene and the sensor.
struct Defocus {
    static constexpr Layer layer = Layer::optics;
    double radius = 0.01;
};
struct Dirt {
    static constexpr Layer layer = Layer::optics;
    double coverage = 0.5;
    double spot = 0.1;
    double red = 0.08, green = 0.06, blue = 0.04;
};
struct WaterDrops {
    static constexpr Layer layer = Layer::optics;
    std::int64_t count = 40;
    double size = 0.08;
};
struct Condensation {
    static constexpr Layer layer = Layer::optics;
    double radius = 0.03;
    double veil = 0.6;
};
struct Covered {
    static constexpr Layer layer = Layer::optics;
    double softness = 0.15;
};

// Sensor: the pixels of a picture.
struct Exposure {
    static constexpr Layer layer = Layer::sensor;
    double factor = 8.0;
};
struct WhiteBalance {
    static constexpr Layer layer = Layer::sensor;
    double red = 1.8, blue = 0.5;
};
struct ChromaLost {
    static constexpr Layer layer = Layer::sensor;
};
struct Noise {
    static constexpr Layer layer = Layer::sensor;
    double deviation = 0.2;
};
struct Banding {
    static constexpr Layer layer = Layer::sensor;
    double depth = 0.5;
    double bands = 4.0;
    double drift_hz = 0.3;
};
struct DeadPixels {
    static constexpr Layer layer = Layer::sensor;
    double share = 0.01;
};
struct DeadRows {
    static constexpr Layer layer = Layer::sensor;
    double share = 0.05;
    bool columns = false;
};
struct Mirrored {
    static constexpr Layer layer = Layer::sensor;
};
struct UpsideDown {
    static constexpr Layer layer = Layer::sensor;
};
struct Tearing {
    static constexpr Layer layer = Layer::sensor;
    double share = 0.5;
};
struct Black {
    static constexpr Layer layer = Layer::sensor;
};

/// Of a kind of output; `any`: of all.
enum class Output : std::uint8_t { any, mjpeg, rtsp, device, v4l2 };
std::span<const Named<Output>> names_of(std::type_identity<Output>);

// Driver: which pictures come, and when.
struct Freeze {
    static constexpr Layer layer = Layer::driver;
    double period_s = 1.0;
};
struct Duplicate {
    static constexpr Layer layer = Layer::driver;
    double probability = 0.5;
};
struct ReducedRate {
    static constexpr Layer layer = Layer::driver;
    double share = 0.9;
};
struct Drop {
    static constexpr Layer layer = Layer::driver;
    double probability = 0.5;
    double burst_frames = 1.0;
};

struct Late {
    static constexpr Layer layer = Layer::driver;
    static constexpr std::int64_t max_frames = 30;
    std::int64_t frames = 5;
    bool in_bursts = false;
    Output output = Output::any;
};

// Transport: what becomes of frames on their way to readers of one kind of output.
enum class Damage : std::uint8_t { truncate, truncate_eoi, bitflip, zero, cut };
std::span<const Named<Damage>> names_of(std::type_identity<Damage>);

struct CorruptJpeg {
    static constexpr Layer layer = Layer::transport;
    Damage mode = Damage::bitflip;
    std::int64_t amount = 1400;
    double probability = 1.0;
    bool keep_header = true;
    Output output = Output::any;
};
struct Stall {
    static constexpr Layer layer = Layer::transport;
    double period_s = 1.0;
    Output output = Output::any;
};
struct Disconnect {
    static constexpr Layer layer = Layer::transport;
    double period_s = 10.0;
    Output output = Output::any;
    bool reset = false;
};
struct Refuse {
    static constexpr Layer layer = Layer::transport;
    double period_s = 10.0;
    Output output = Output::any;
};
struct Restart {
    static constexpr Layer layer = Layer::transport;
    double period_s = 10.0;
    Output output = Output::any;
};
struct Bandwidth {
    static constexpr Layer layer = Layer::transport;
    double kbit_per_s = 500.0;
    double queue_s = 0.2;
    Output output = Output::any;
};
struct CutPart {
    static constexpr Layer layer = Layer::transport;
    double probability = 0.05;
};
struct PacketLoss {
    static constexpr Layer layer = Layer::transport;
    double probability = 0.1;
};
struct PacketReorder {
    static constexpr Layer layer = Layer::transport;
    double probability = 0.1;
    std::int64_t distance = 3;
};
struct PacketDelay {
    static constexpr Layer layer = Layer::transport;
    static constexpr double max_delay_s = 5.0;
    double probability = 0.1;
    double delay_s = 0.1;
    double jitter_s = 0.0;
};
struct NewSsrc {
    static constexpr Layer layer = Layer::transport;
    double period_s = 5.0;
};
/// What of an HTTP stream's part is wrong.
enum class PartError : std::uint8_t { length, boundary };
std::span<const Named<PartError>> names_of(std::type_identity<PartError>);
struct BadPart {
    static constexpr Layer layer = Layer::transport;
    PartError mode = PartError::length;
    double probability = 0.1;
};
enum class VideoDamage : std::uint8_t { bitflip, drop_nal, drop_idr };
std::span<const Named<VideoDamage>> names_of(std::type_identity<VideoDamage>);
struct CorruptVideo {
    static constexpr Layer layer = Layer::transport;
    VideoDamage mode = VideoDamage::bitflip;
    std::int64_t amount = 20;
    double probability = 0.5;
};
struct BufferError {
    static constexpr Layer layer = Layer::transport;
    double probability = 0.2;
};
struct WrongSize {
    static constexpr Layer layer = Layer::transport;
    double share = 0.5;
    double probability = 1.0;
};
struct OtherSize {
    static constexpr Layer layer = Layer::transport;
    double share = 0.5;
    double probability = 1.0;
    Output output = Output::any;
};
/// Which call of programs fails, by the names of vivid's controls.
enum class DeviceCall : std::uint8_t { reqbufs, qbuf, streamon, streaming };
std::span<const Named<DeviceCall>> names_of(std::type_identity<DeviceCall>);
struct DeviceError {
    static constexpr Layer layer = Layer::transport;
    DeviceCall at = DeviceCall::qbuf;
    double period_s = 10.0;
};
struct Unplug {
    static constexpr Layer layer = Layer::transport;
    double period_s = 10.0;
    int as_number = -1;
    bool replug_resets_controls = true;
};

/// In the order in which they act.
using FaultKind =
    std::variant<Knock, Sag, Vibration, Defocus, Dirt, WaterDrops, Condensation, Covered, Exposure, WhiteBalance,
                 ChromaLost, Noise, Banding, DeadPixels, DeadRows, Mirrored, UpsideDown, Tearing, Black, Freeze,
                 Duplicate, ReducedRate, Drop, Late, CorruptJpeg, OtherSize, Stall, Disconnect, Refuse, Restart,
                 Bandwidth, CutPart, PacketLoss, PacketReorder, PacketDelay, NewSsrc, BadPart, CorruptVideo,
                 BufferError, WrongSize, DeviceError, Unplug>;

/// The table of all kinds, in the order of the variant: JSON, documentation and clients come from it.
const std::vector<Kind<FaultKind>>& fault_kinds();
std::string_view name_of(const FaultKind& kind);
Layer layer_of(const FaultKind& kind);
/// A wiper takes it from the glass.
bool is_wiped(const FaultKind& kind);
/// Its parameters, as an object.
nlohmann::json params_of(const FaultKind& kind);

}  // namespace camrig::fault
