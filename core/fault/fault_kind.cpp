#include "core/fault/fault_kind.h"

#include "core/base/result.h"

namespace camrig::fault {

std::span<const Named<Layer>> names_of(std::type_identity<Layer>) {
    static constexpr Named<Layer> names[] = {{Layer::body, "body"},
                                             {Layer::optics, "optics"},
                                             {Layer::sensor, "sensor"},
                                             {Layer::driver, "driver"},
                                             {Layer::transport, "transport"}};
    return names;
}

std::span<const Named<Damage>> names_of(std::type_identity<Damage>) {
    static constexpr Named<Damage> names[] = {{Damage::truncate, "truncate"},
                                              {Damage::truncate_eoi, "truncate_eoi"},
                                              {Damage::bitflip, "bitflip"},
                                              {Damage::zero, "zero"},
                                              {Damage::cut, "cut"}};
    return names;
}

std::span<const Named<Output>> names_of(std::type_identity<Output>) {
    static constexpr Named<Output> names[] = {{Output::any, "any"},
                                              {Output::mjpeg, "mjpeg"},
                                              {Output::rtsp, "rtsp"},
                                              {Output::device, "device"},
                                              {Output::v4l2, "v4l2"}};
    return names;
}

std::span<const Named<PartError>> names_of(std::type_identity<PartError>) {
    static constexpr Named<PartError> names[] = {{PartError::length, "length"}, {PartError::boundary, "boundary"}};
    return names;
}

std::span<const Named<VideoDamage>> names_of(std::type_identity<VideoDamage>) {
    static constexpr Named<VideoDamage> names[] = {
        {VideoDamage::bitflip, "bitflip"}, {VideoDamage::drop_nal, "drop_nal"}, {VideoDamage::drop_idr, "drop_idr"}};
    return names;
}

std::span<const Named<DeviceCall>> names_of(std::type_identity<DeviceCall>) {
    static constexpr Named<DeviceCall> names[] = {{DeviceCall::reqbufs, "reqbufs"},
                                                  {DeviceCall::qbuf, "qbuf"},
                                                  {DeviceCall::streamon, "streamon"},
                                                  {DeviceCall::streaming, "streaming"}};
    return names;
}

namespace {

/// Degrees about one of the camera's axes.
template <auto member>
auto degrees_at(const char* name, const char* doc) {
    return field_at<member>({.name = name, .doc = doc, .unit = "deg", .range = {-180, 180}});
}
/// A share of something.
template <auto member>
auto share_at(const char* name, const char* doc, double most = 1.0) {
    return field_at<member>({.name = name, .doc = doc, .range = {0, most}});
}
template <auto member>
auto output_at() {
    return field_at<member>({.name = "output", .doc = "whose readers have it; others do not notice"});
}
template <auto member>
auto period_at(const char* doc, double most = 3600) {
    return field_at<member>({.name = "period_s", .doc = doc, .unit = "s", .range = {0.01, most}});
}
constexpr const char* share_of_period = "below severity 1 it lasts for this share of each period";

FieldTable<Knock> fields_of(std::type_identity<Knock>) {
    static const std::vector<FieldOf<Knock>> table{
        degrees_at<&Knock::pan_deg>("pan_deg", "positive is to the left"),
        degrees_at<&Knock::tilt_deg>("tilt_deg", "positive is upwards"),
        degrees_at<&Knock::roll_deg>("roll_deg", "positive is clockwise, as the camera sees it")};
    return table;
}

FieldTable<Sag> fields_of(std::type_identity<Sag>) {
    static const std::vector<FieldOf<Sag>> table{field_at<&Sag::tilt_deg_per_h>(
        {.name = "tilt_deg_per_h", .doc = "positive is upwards; up to 90 deg", .unit = "deg/h", .range = {-1e5, 1e5}})};
    return table;
}

FieldTable<Vibration> fields_of(std::type_identity<Vibration>) {
    static const std::vector<FieldOf<Vibration>> table{
        field_at<&Vibration::amplitude_deg>({.name = "amplitude_deg",
                                             .doc = "of pan and of tilt, a quarter of a period apart",
                                             .unit = "deg",
                                             .range = {0, 45}}),
        field_at<&Vibration::frequency_hz>({.name = "frequency_hz", .unit = "Hz", .range = {0.01, 1000}})};
    return table;
}

FieldTable<Defocus> fields_of(std::type_identity<Defocus>) {
    static const std::vector<FieldOf<Defocus>> table{
        share_at<&Defocus::radius>("radius", "of the blur, as a share of the picture's width", 0.1)};
    return table;
}

FieldTable<Dirt> fields_of(std::type_identity<Dirt>) {
    static const std::vector<FieldOf<Dirt>> table{
        share_at<&Dirt::coverage>("coverage", "share of the picture that dirt takes more than half of the light of"),
        field_at<&Dirt::spot>(
            {.name = "spot", .doc = "size of a spot, as a share of the picture's width", .range = {0.01, 1}}),
        share_at<&Dirt::red>("red", "of the dirt, linear"), share_at<&Dirt::green>("green", "the same"),
        share_at<&Dirt::blue>("blue", "the same")};
    return table;
}

FieldTable<WaterDrops> fields_of(std::type_identity<WaterDrops>) {
    static const std::vector<FieldOf<WaterDrops>> table{
        field_at<&WaterDrops::count>({.name = "count", .doc = "of drops", .range = {1, 500}}),
        field_at<&WaterDrops::size>({.name = "size",
                                     .doc = "of a drop, as a share of the picture's width; some are half as large",
                                     .range = {0.005, 0.5}})};
    return table;
}

FieldTable<Condensation> fields_of(std::type_identity<Condensation>) {
    static const std::vector<FieldOf<Condensation>> table{
        share_at<&Condensation::radius>("radius", "of the blur, as a share of the picture's width", 0.1),
        share_at<&Condensation::veil>("veil", "of the light that is scattered, and is the same grey everywhere")};
    return table;
}

FieldTable<Covered> fields_of(std::type_identity<Covered>) {
    static const std::vector<FieldOf<Covered>> table{
        share_at<&Covered::softness>("softness", "width of the blurred edge, as a share of the picture's height")};
    return table;
}

FieldTable<Exposure> fields_of(std::type_identity<Exposure>) {
    static const std::vector<FieldOf<Exposure>> table{
        field_at<&Exposure::factor>({.name = "factor",
                                     .doc = "of the light that is right; below 1 the picture is too dark",
                                     .range = {0.001, 1000}})};
    return table;
}

FieldTable<WhiteBalance> fields_of(std::type_identity<WhiteBalance>) {
    static const std::vector<FieldOf<WhiteBalance>> table{
        field_at<&WhiteBalance::red>({.name = "red", .doc = "factor on linear red", .range = {0.01, 100}}),
        field_at<&WhiteBalance::blue>({.name = "blue", .doc = "the same on blue", .range = {0.01, 100}})};
    return table;
}

FieldTable<ChromaLost> fields_of(std::type_identity<ChromaLost>) {
    static const std::vector<FieldOf<ChromaLost>> table;
    return table;
}

FieldTable<Noise> fields_of(std::type_identity<Noise>) {
    static const std::vector<FieldOf<Noise>> table{share_at<&Noise::deviation>(
        "deviation", "standard deviation, as a share of white; 0.08 to 0.38 is ImageNet-C's")};
    return table;
}

FieldTable<Banding> fields_of(std::type_identity<Banding>) {
    static const std::vector<FieldOf<Banding>> table{
        share_at<&Banding::depth>("depth", "of the light that the dark bands lack"),
        field_at<&Banding::bands>({.name = "bands", .doc = "in the picture's height", .range = {0.1, 100}}),
        field_at<&Banding::drift_hz>(
            {.name = "drift_hz", .doc = "so many bands pass a row in a second", .unit = "Hz", .range = {-1000, 1000}})};
    return table;
}

FieldTable<DeadPixels> fields_of(std::type_identity<DeadPixels>) {
    static const std::vector<FieldOf<DeadPixels>> table{
        share_at<&DeadPixels::share>("share", "of all pixels; half of them are black, half white", 0.1)};
    return table;
}

FieldTable<DeadRows> fields_of(std::type_identity<DeadRows>) {
    static const std::vector<FieldOf<DeadRows>> table{
        share_at<&DeadRows::share>("share", "of all rows; each is black or white"),
        field_at<&DeadRows::columns>({.name = "columns", .doc = "columns instead of rows"})};
    return table;
}

FieldTable<Mirrored> fields_of(std::type_identity<Mirrored>) {
    static const std::vector<FieldOf<Mirrored>> table;
    return table;
}

FieldTable<UpsideDown> fields_of(std::type_identity<UpsideDown>) {
    static const std::vector<FieldOf<UpsideDown>> table;
    return table;
}

FieldTable<Tearing> fields_of(std::type_identity<Tearing>) {
    static const std::vector<FieldOf<Tearing>> table{
        share_at<&Tearing::share>("share", "of the picture, from below, that is of the frame before")};
    return table;
}

FieldTable<Black> fields_of(std::type_identity<Black>) {
    static const std::vector<FieldOf<Black>> table;
    return table;
}

FieldTable<ReducedRate> fields_of(std::type_identity<ReducedRate>) {
    static const std::vector<FieldOf<ReducedRate>> table{
        share_at<&ReducedRate::share>("share", "of frames that are left out, evenly")};
    return table;
}

FieldTable<Late> fields_of(std::type_identity<Late>) {
    static const std::vector<FieldOf<Late>> table{
        field_at<&Late::frames>({.name = "frames",
                                 .doc = "a frame comes when so many later ones are due",
                                 .range = {1, static_cast<double>(Late::max_frames)}}),
        field_at<&Late::in_bursts>(
            {.name = "in_bursts", .doc = "so many are kept and come together with the one after them"}),
        output_at<&Late::output>()};
    return table;
}

FieldTable<CorruptJpeg> fields_of(std::type_identity<CorruptJpeg>) {
    static const std::vector<FieldOf<CorruptJpeg>> table{
        field_at<&CorruptJpeg::mode>(
            {.name = "mode",
             .doc =
                 "truncate: the end is missing; truncate_eoi: the same, and a marker says that it ends there; bitflip; "
                 "zero: a run of bytes is 0, as where a packet was lost; cut: a run of bytes is missing"}),
        field_at<&CorruptJpeg::amount>(
            {.name = "amount", .doc = "bytes, or flips; at most all there are", .range = {1, 100'000'000}}),
        share_at<&CorruptJpeg::probability>("probability", "of each frame"),
        field_at<&CorruptJpeg::keep_header>(
            {.name = "keep_header", .doc = "only what follows SOS is damaged, so that decoders take it"}),
        output_at<&CorruptJpeg::output>()};
    return table;
}

FieldTable<Stall> fields_of(std::type_identity<Stall>) {
    static const std::vector<FieldOf<Stall>> table{period_at<&Stall::period_s>(share_of_period),
                                                   output_at<&Stall::output>()};
    return table;
}

FieldTable<Disconnect> fields_of(std::type_identity<Disconnect>) {
    static const std::vector<FieldOf<Disconnect>> table{
        period_at<&Disconnect::period_s>(share_of_period), output_at<&Disconnect::output>(),
        field_at<&Disconnect::reset>(
            {.name = "reset",
             .doc = "connections of HTTP and RTSP break (TCP RST): no end of the stream and no BYE come before"})};
    return table;
}

FieldTable<Refuse> fields_of(std::type_identity<Refuse>) {
    static const std::vector<FieldOf<Refuse>> table{period_at<&Refuse::period_s>(share_of_period),
                                                    output_at<&Refuse::output>()};
    return table;
}

FieldTable<Restart> fields_of(std::type_identity<Restart>) {
    static const std::vector<FieldOf<Restart>> table{period_at<&Restart::period_s>(share_of_period),
                                                     output_at<&Restart::output>()};
    return table;
}

FieldTable<Bandwidth> fields_of(std::type_identity<Bandwidth>) {
    static const std::vector<FieldOf<Bandwidth>> table{
        field_at<&Bandwidth::kbit_per_s>({.name = "kbit_per_s",
                                          .doc = "what the line carries for each reader or RTSP stream; below severity "
                                                 "1 so much more: it is divided by the severity",
                                          .unit = "kbit/s",
                                          .range = {1, 1e7}}),
        field_at<&Bandwidth::queue_s>({.name = "queue_s",
                                       .doc = "what would wait longer than this before the line does not come",
                                       .unit = "s",
                                       .range = {0, 10}}),
        output_at<&Bandwidth::output>()};
    return table;
}

FieldTable<PacketReorder> fields_of(std::type_identity<PacketReorder>) {
    static const std::vector<FieldOf<PacketReorder>> table{
        share_at<&PacketReorder::probability>("probability", "of each RTP packet"),
        field_at<&PacketReorder::distance>({.name = "distance",
                                            .doc = "so many packets overtake it, or all that are left of its picture",
                                            .range = {1, 100}})};
    return table;
}

FieldTable<PacketDelay> fields_of(std::type_identity<PacketDelay>) {
    static const std::vector<FieldOf<PacketDelay>> table{
        share_at<&PacketDelay::probability>("probability", "of each RTP packet"),
        field_at<&PacketDelay::delay_s>({.name = "delay_s",
                                         .doc = "so long a packet is on its way; it comes with the first that is sent "
                                                "from then on",
                                         .unit = "s",
                                         .range = {0.0, PacketDelay::max_delay_s}}),
        field_at<&PacketDelay::jitter_s>({.name = "jitter_s",
                                          .doc = "and up to so much longer, each packet by itself",
                                          .unit = "s",
                                          .range = {0.0, PacketDelay::max_delay_s}})};
    return table;
}
FieldTable<NewSsrc> fields_of(std::type_identity<NewSsrc>) {
    static const std::vector<FieldOf<NewSsrc>> table{
        period_at<&NewSsrc::period_s>("at its begin and each time so long after it; below severity 1 so much more "
                                      "seldom: it is divided by the severity")};
    return table;
}

FieldTable<CutPart> fields_of(std::type_identity<CutPart>) {
    static const std::vector<FieldOf<CutPart>> table{share_at<&CutPart::probability>("probability", "of each part")};
    return table;
}

FieldTable<PacketLoss> fields_of(std::type_identity<PacketLoss>) {
    static const std::vector<FieldOf<PacketLoss>> table{
        share_at<&PacketLoss::probability>("probability", "of each RTP packet")};
    return table;
}

FieldTable<BadPart> fields_of(std::type_identity<BadPart>) {
    static const std::vector<FieldOf<BadPart>> table{
        field_at<&BadPart::mode>({.name = "mode",
                                  .doc = "length: Content-Length is half as large again as the picture; boundary: the "
                                         "line between it and the next part is missing"}),
        share_at<&BadPart::probability>("probability", "of each part")};
    return table;
}

FieldTable<CorruptVideo> fields_of(std::type_identity<CorruptVideo>) {
    static const std::vector<FieldOf<CorruptVideo>> table{
        field_at<&CorruptVideo::mode>(
            {.name = "mode",
             .doc = "bitflip: bits behind the headers of slices; drop_nal: slices are missing; drop_idr: those of key "
                    "frames are, so that readers wait or smear until the next"}),
        field_at<&CorruptVideo::amount>(
            {.name = "amount", .doc = "bitflip: flips in each slice that is hit", .range = {1, 1'000'000}}),
        share_at<&CorruptVideo::probability>("probability", "of each slice, with drop_idr of each key frame")};
    return table;
}

FieldTable<BufferError> fields_of(std::type_identity<BufferError>) {
    static const std::vector<FieldOf<BufferError>> table{
        share_at<&BufferError::probability>("probability", "of each frame")};
    return table;
}

FieldTable<WrongSize> fields_of(std::type_identity<WrongSize>) {
    static const std::vector<FieldOf<WrongSize>> table{
        share_at<&WrongSize::share>("share", "of the picture's bytes that are missing at its end"),
        share_at<&WrongSize::probability>("probability", "of each frame")};
    return table;
}

FieldTable<OtherSize> fields_of(std::type_identity<OtherSize>) {
    static const std::vector<FieldOf<OtherSize>> table{
        share_at<&OtherSize::share>("share", "of width and height that is missing, down to 16 pixels", 0.99),
        share_at<&OtherSize::probability>("probability", "of each frame"), output_at<&OtherSize::output>()};
    return table;
}

FieldTable<DeviceError> fields_of(std::type_identity<DeviceError>) {
    static const std::vector<FieldOf<DeviceError>> table{
        field_at<&DeviceError::at>({.name = "at",
                                    .doc = "reqbufs, qbuf, streamon: that ioctl gives EINVAL; streaming: queueing and "
                                           "dequeueing give EIO, until STREAMOFF"}),
        period_at<&DeviceError::period_s>(share_of_period)};
    return table;
}

FieldTable<Unplug> fields_of(std::type_identity<Unplug>) {
    static const std::vector<FieldOf<Unplug>> table{
        period_at<&Unplug::period_s>(share_of_period),
        field_at<&Unplug::as_number>(
            {.name = "as_number", .doc = "the number it comes back under; -1: the same", .range = {-1, 255}}),
        field_at<&Unplug::replug_resets_controls>(
            {.name = "replug_resets_controls", .doc = "it comes back with the defaults of its image controls"})};
    return table;
}

FieldTable<Freeze> fields_of(std::type_identity<Freeze>) {
    static const std::vector<FieldOf<Freeze>> table{
        field_at<&Freeze::period_s>({.name = "period_s",
                                     .doc = "below severity 1 the picture stands for this share of each period",
                                     .unit = "s",
                                     .range = {0.01, 3600}})};
    return table;
}

FieldTable<Duplicate> fields_of(std::type_identity<Duplicate>) {
    static const std::vector<FieldOf<Duplicate>> table{
        field_at<&Duplicate::probability>({.name = "probability", .doc = "of each frame", .range = {0, 1}})};
    return table;
}

FieldTable<Drop> fields_of(std::type_identity<Drop>) {
    static const std::vector<FieldOf<Drop>> table{
        field_at<&Drop::probability>(
            {.name = "probability", .doc = "share of frames in the long run", .range = {0, 1}}),
        field_at<&Drop::burst_frames>(
            {.name = "burst_frames",
             .doc = "so many are lost in a row on average (Gilbert's model); 1, or less than 1 / (1 - probability): "
                    "each frame on its own",
             .range = {1, 1000}})};
    return table;
}

std::vector<Kind<FaultKind>> make_kinds() {
    std::vector<Kind<FaultKind>> kinds;
    const auto add = [&]<typename T>(std::type_identity<T> type, const char* name, const char* doc) {
        kinds.push_back(kind_of<FaultKind, T>({.name = name, .doc = doc}, fields_of(type)));
    };
    add(std::type_identity<Knock>{}, "knock", "the camera is turned, and its calibration does not know");
    add(std::type_identity<Sag>{}, "sag", "it turns down slowly from its begin on");
    add(std::type_identity<Vibration>{}, "vibration", "it swings to and fro");
    add(std::type_identity<Defocus>{}, "defocus", "the picture is out of focus");
    add(std::type_identity<Dirt>{}, "dirt", "blurred spots of dirt on the glass");
    add(std::type_identity<WaterDrops>{}, "drops",
        "drops of water on the glass, each a small lens that shows it upside down");
    add(std::type_identity<Condensation>{}, "condensation", "the glass is fogged: blurred, and grey over all");
    add(std::type_identity<Covered>{}, "covered", "something dark comes before the lens from above");
    add(std::type_identity<Exposure>{}, "exposure", "exposure is stuck where it is wrong");
    add(std::type_identity<WhiteBalance>{}, "white_balance", "the balance of colours is wrong");
    add(std::type_identity<ChromaLost>{}, "chroma_lost", "colours are gone, at severity 1 all is grey");
    add(std::type_identity<Noise>{}, "noise", "noise that is another in every frame");
    add(std::type_identity<Banding>{}, "banding", "dark bands, as of lamps on the mains");
    add(std::type_identity<DeadPixels>{}, "dead_pixels", "pixels that are always black or white");
    add(std::type_identity<DeadRows>{}, "dead_rows", "rows or columns that are always black or white");
    add(std::type_identity<Mirrored>{}, "mirrored", "left and right are exchanged, at any severity over 0");
    add(std::type_identity<UpsideDown>{}, "upside_down", "turned by 180 deg, at any severity over 0");
    add(std::type_identity<Tearing>{}, "tearing", "the lower part of the picture is of the frame before");
    add(std::type_identity<Black>{}, "black",
        "the picture is darker by this share; at severity 1 it is black and not drawn");
    add(std::type_identity<Freeze>{}, "freeze", "the same picture again and again, while stamps go on");
    add(std::type_identity<Duplicate>{}, "duplicate", "a frame has the picture of the one before it");
    add(std::type_identity<ReducedRate>{}, "reduced_rate", "fewer frames come than the camera says");
    add(std::type_identity<Drop>{}, "drop", "frames do not come; their numbers are missing");
    add(std::type_identity<Late>{}, "late", "frames come late, with the stamps of when they were taken");
    add(std::type_identity<CorruptJpeg>{}, "corrupt_jpeg", "bytes of JPEGs in streams are damaged");
    add(std::type_identity<OtherSize>{}, "other_size", "JPEGs in streams are of a smaller size than the camera's");
    add(std::type_identity<Stall>{}, "stall", "no frames go out, and connections stay open");
    add(std::type_identity<Disconnect>{}, "disconnect", "readers are thrown out, and again when they come back");
    add(std::type_identity<Refuse>{}, "refuse", "who comes is refused; who is there stays");
    add(std::type_identity<Restart>{}, "restart", "the camera's servers are down: readers are thrown out and refused");
    add(std::type_identity<Bandwidth>{}, "bandwidth", "the line carries less than the pictures need");
    add(std::type_identity<CutPart>{}, "cut_part", "an HTTP stream is closed in the middle of a picture");
    add(std::type_identity<PacketLoss>{}, "packet_loss", "RTP packets are lost; their sequence numbers are missing");
    add(std::type_identity<PacketReorder>{}, "packet_reorder", "RTP packets are overtaken by later ones");
    add(std::type_identity<PacketDelay>{}, "packet_delay", "RTP packets come later, behind those of later pictures");
    add(std::type_identity<NewSsrc>{}, "new_ssrc", "RTP goes on as another source (SSRC) in the middle of a session");
    add(std::type_identity<BadPart>{}, "bad_part", "an HTTP stream says what is not so of its parts");
    add(std::type_identity<CorruptVideo>{}, "corrupt_video", "H.264 and H.265 in streams is damaged");
    add(std::type_identity<BufferError>{}, "buffer_error",
        "user-space devices give buffers with V4L2_BUF_FLAG_ERROR, as vivid injects it");
    add(std::type_identity<WrongSize>{}, "wrong_size",
        "user-space devices give fewer bytes (bytesused) than the format says");
    add(std::type_identity<DeviceError>{}, "device_error", "calls of user-space devices fail, as vivid injects it");
    add(std::type_identity<Unplug>{}, "unplug", "user-space devices go, with their nodes, and come back after it");
    CHECK(kinds.size() == std::variant_size_v<FaultKind>);
    return kinds;
}

}  // namespace

const std::vector<Kind<FaultKind>>& fault_kinds() {
    static const std::vector<Kind<FaultKind>> kinds = make_kinds();
    return kinds;
}

std::string_view name_of(const FaultKind& kind) {
    return fault_kinds()[kind.index()].description.name;
}

Layer layer_of(const FaultKind& kind) {
    return std::visit([]<typename T>(const T&) { return T::layer; }, kind);
}

bool is_wiped(const FaultKind& kind) {
    return std::holds_alternative<Dirt>(kind) || std::holds_alternative<WaterDrops>(kind) ||
           std::holds_alternative<Condensation>(kind);
}

nlohmann::json params_of(const FaultKind& kind) {
    return std::visit([]<typename T>(const T& one) { return write_fields(fields_of(std::type_identity<T>{}), one); },
                      kind);
}

}  // namespace camrig::fault
