#include "core/fault/fault_kind.h"

#include <functional>

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

/// The kinds in the order of the variant, and what writes the parameters of each.
struct Kinds {
    template <typename T>
    void add(const char* name, const char* doc, const std::vector<FieldOf<T>>& parameters) {
        CHECK(FaultKind(T{}).index() == kinds.size());
        kinds.push_back(kind_of<FaultKind, T>({.name = name, .doc = doc}, parameters));
        writers.push_back([parameters](const FaultKind& kind) { return write_fields(parameters, std::get<T>(kind)); });
    }

    std::vector<Kind<FaultKind>> kinds;
    std::vector<std::function<nlohmann::json(const FaultKind&)>> writers;
};

void add_body_kinds(Kinds& to) {
    to.add<Knock>("knock", "the camera is turned, and its calibration does not know",
                  {degrees_at<&Knock::pan_deg>("pan_deg", "positive is to the left"),
                   degrees_at<&Knock::tilt_deg>("tilt_deg", "positive is upwards"),
                   degrees_at<&Knock::roll_deg>("roll_deg", "positive is clockwise, as the camera sees it")});
    to.add<Sag>("sag", "it turns down slowly from its begin on",
                {field_at<&Sag::tilt_deg_per_h>({.name = "tilt_deg_per_h",
                                                 .doc = "positive is upwards; up to 90 deg",
                                                 .unit = "deg/h",
                                                 .range = {-1e5, 1e5}})});
    to.add<Vibration>(
        "vibration", "it swings to and fro",
        {field_at<&Vibration::amplitude_deg>({.name = "amplitude_deg",
                                              .doc = "of pan and of tilt, a quarter of a period apart",
                                              .unit = "deg",
                                              .range = {0, 45}}),
         field_at<&Vibration::frequency_hz>({.name = "frequency_hz", .unit = "Hz", .range = {0.01, 1000}})});
}

void add_optics_kinds(Kinds& to) {
    to.add<Defocus>("defocus", "the picture is out of focus",
                    {share_at<&Defocus::radius>("radius", "of the blur, as a share of the picture's width", 0.1)});
    to.add<Dirt>(
        "dirt", "blurred spots of dirt on the glass",
        {share_at<&Dirt::coverage>("coverage", "share of the picture that dirt takes more than half of the light of"),
         field_at<&Dirt::spot>(
             {.name = "spot", .doc = "size of a spot, as a share of the picture's width", .range = {0.01, 1}}),
         share_at<&Dirt::red>("red", "of the dirt, linear"), share_at<&Dirt::green>("green", "the same"),
         share_at<&Dirt::blue>("blue", "the same")});
    to.add<WaterDrops>(
        "drops", "drops of water on the glass, each a small lens that shows it upside down",
        {field_at<&WaterDrops::count>({.name = "count", .doc = "of drops", .range = {1, 500}}),
         field_at<&WaterDrops::size>({.name = "size",
                                      .doc = "of a drop, as a share of the picture's width; some are half as large",
                                      .range = {0.005, 0.5}})});
    to.add<Condensation>(
        "condensation", "the glass is fogged: blurred, and grey over all",
        {share_at<&Condensation::radius>("radius", "of the blur, as a share of the picture's width", 0.1),
         share_at<&Condensation::veil>("veil", "of the light that is scattered, and is the same grey everywhere")});
    to.add<Covered>(
        "covered", "something dark comes before the lens from above",
        {share_at<&Covered::softness>("softness", "width of the blurred edge, as a share of the picture's height")});
}

void add_sensor_kinds(Kinds& to) {
    to.add<Exposure>("exposure", "exposure is stuck where it is wrong",
                     {field_at<&Exposure::factor>({.name = "factor",
                                                   .doc = "of the light that is right; below 1 the picture is too dark",
                                                   .range = {0.001, 1000}})});
    to.add<WhiteBalance>(
        "white_balance", "the balance of colours is wrong",
        {field_at<&WhiteBalance::red>({.name = "red", .doc = "factor on linear red", .range = {0.01, 100}}),
         field_at<&WhiteBalance::blue>({.name = "blue", .doc = "the same on blue", .range = {0.01, 100}})});
    to.add<ChromaLost>("chroma_lost", "colours are gone, at severity 1 all is grey", {});
    to.add<Noise>("noise", "noise that is another in every frame",
                  {share_at<&Noise::deviation>(
                      "deviation", "standard deviation, as a share of white; 0.08 to 0.38 is ImageNet-C's")});
    to.add<Banding>(
        "banding", "dark bands, as of lamps on the mains",
        {share_at<&Banding::depth>("depth", "of the light that the dark bands lack"),
         field_at<&Banding::bands>({.name = "bands", .doc = "in the picture's height", .range = {0.1, 100}}),
         field_at<&Banding::drift_hz>({.name = "drift_hz",
                                       .doc = "so many bands pass a row in a second",
                                       .unit = "Hz",
                                       .range = {-1000, 1000}})});
    to.add<DeadPixels>(
        "dead_pixels", "pixels that are always black or white",
        {share_at<&DeadPixels::share>("share", "of all pixels; half of them are black, half white", 0.1)});
    to.add<DeadRows>("dead_rows", "rows or columns that are always black or white",
                     {share_at<&DeadRows::share>("share", "of all rows; each is black or white"),
                      field_at<&DeadRows::columns>({.name = "columns", .doc = "columns instead of rows"})});
    to.add<Mirrored>("mirrored", "left and right are exchanged, at any severity over 0", {});
    to.add<UpsideDown>("upside_down", "turned by 180 deg, at any severity over 0", {});
    to.add<Tearing>("tearing", "the lower part of the picture is of the frame before",
                    {share_at<&Tearing::share>("share", "of the picture, from below, that is of the frame before")});
    to.add<Black>("black", "the picture is darker by this share; at severity 1 it is black and not drawn", {});
}

void add_driver_kinds(Kinds& to) {
    to.add<Freeze>(
        "freeze", "the same picture again and again, while stamps go on",
        {field_at<&Freeze::period_s>({.name = "period_s",
                                      .doc = "below severity 1 the picture stands for this share of each period",
                                      .unit = "s",
                                      .range = {0.01, 3600}})});
    to.add<Duplicate>(
        "duplicate", "a frame has the picture of the one before it",
        {field_at<&Duplicate::probability>({.name = "probability", .doc = "of each frame", .range = {0, 1}})});
    to.add<ReducedRate>("reduced_rate", "fewer frames come than the camera says",
                        {share_at<&ReducedRate::share>("share", "of frames that are left out, evenly")});
    to.add<Drop>(
        "drop", "frames do not come; their numbers are missing",
        {field_at<&Drop::probability>(
             {.name = "probability", .doc = "share of frames in the long run", .range = {0, 1}}),
         field_at<&Drop::burst_frames>(
             {.name = "burst_frames",
              .doc = "so many are lost in a row on average (Gilbert's model); 1, or less than 1 / (1 - probability): "
                     "each frame on its own",
              .range = {1, 1000}})});
    to.add<Late>("late", "frames come late, with the stamps of when they were taken",
                 {field_at<&Late::frames>({.name = "frames",
                                           .doc = "a frame comes when so many later ones are due",
                                           .range = {1, static_cast<double>(Late::max_frames)}}),
                  field_at<&Late::in_bursts>(
                      {.name = "in_bursts", .doc = "so many are kept and come together with the one after them"}),
                  output_at<&Late::output>()});
}

void add_transport_kinds(Kinds& to) {
    to.add<CorruptJpeg>(
        "corrupt_jpeg", "bytes of JPEGs in streams are damaged",
        {field_at<&CorruptJpeg::mode>(
             {.name = "mode",
              .doc = "truncate: the end is missing; truncate_eoi: the same, and a marker says that it ends there; "
                     "bitflip; "
                     "zero: a run of bytes is 0, as where a packet was lost; cut: a run of bytes is missing"}),
         field_at<&CorruptJpeg::amount>(
             {.name = "amount", .doc = "bytes, or flips; at most all there are", .range = {1, 100'000'000}}),
         share_at<&CorruptJpeg::probability>("probability", "of each frame"),
         field_at<&CorruptJpeg::keep_header>({.name = "keep_header",
                                              .doc = "only what follows SOS is damaged, so that decoders take it; by "
                                                     "RTSP, which sends no header, always"}),
         output_at<&CorruptJpeg::output>()});
    to.add<OtherSize>(
        "other_size", "JPEGs in streams are of a smaller size than the camera's",
        {share_at<&OtherSize::share>("share", "of width and height that is missing, down to 16 pixels", 0.99),
         share_at<&OtherSize::probability>("probability", "of each frame"), output_at<&OtherSize::output>()});
    to.add<Stall>("stall", "no frames go out, and connections stay open",
                  {period_at<&Stall::period_s>(share_of_period), output_at<&Stall::output>()});
    to.add<Disconnect>(
        "disconnect", "readers are thrown out, and again when they come back",
        {period_at<&Disconnect::period_s>(share_of_period), output_at<&Disconnect::output>(),
         field_at<&Disconnect::reset>(
             {.name = "reset",
              .doc = "connections of HTTP and RTSP break (TCP RST): no end of the stream and no BYE come before"})});
    to.add<Refuse>("refuse", "who comes is refused; who is there stays",
                   {period_at<&Refuse::period_s>(share_of_period), output_at<&Refuse::output>()});
    to.add<Restart>("restart", "the camera's servers are down: readers are thrown out and refused",
                    {period_at<&Restart::period_s>(share_of_period), output_at<&Restart::output>()});
    to.add<Bandwidth>(
        "bandwidth", "the line carries less than the pictures need",
        {field_at<&Bandwidth::kbit_per_s>({.name = "kbit_per_s",
                                           .doc =
                                               "what the line carries for each reader or RTSP stream; below severity "
                                               "1 so much more: it is divided by the severity",
                                           .unit = "kbit/s",
                                           .range = {1, 1e7}}),
         field_at<&Bandwidth::queue_s>({.name = "queue_s",
                                        .doc = "what would wait longer than this before the line does not come",
                                        .unit = "s",
                                        .range = {0, 10}}),
         output_at<&Bandwidth::output>()});
    to.add<CutPart>("cut_part", "an HTTP stream is closed in the middle of a picture",
                    {share_at<&CutPart::probability>("probability", "of each part")});
    to.add<PacketLoss>("packet_loss", "RTP packets are lost; their sequence numbers are missing",
                       {share_at<&PacketLoss::probability>("probability", "of each RTP packet")});
    to.add<PacketReorder>(
        "packet_reorder", "RTP packets are overtaken by later ones",
        {share_at<&PacketReorder::probability>("probability", "of each RTP packet"),
         field_at<&PacketReorder::distance>({.name = "distance",
                                             .doc = "so many packets overtake it, or all that are left of its picture",
                                             .range = {1, 100}})});
    to.add<PacketDelay>(
        "packet_delay", "RTP packets come later, behind those of later pictures",
        {share_at<&PacketDelay::probability>("probability", "of each RTP packet"),
         field_at<&PacketDelay::delay_s>({.name = "delay_s",
                                          .doc = "so long a packet is on its way; it comes with the first that is sent "
                                                 "from then on",
                                          .unit = "s",
                                          .range = {0.0, PacketDelay::max_delay_s}}),
         field_at<&PacketDelay::jitter_s>({.name = "jitter_s",
                                           .doc = "and up to so much longer, each packet by itself",
                                           .unit = "s",
                                           .range = {0.0, PacketDelay::max_delay_s}})});
    to.add<NewSsrc>(
        "new_ssrc", "RTP goes on as another source (SSRC) in the middle of a session",
        {period_at<&NewSsrc::period_s>("at its begin and each time so long after it; below severity 1 so much more "
                                       "seldom: it is divided by the severity")});
    to.add<BadPart>(
        "bad_part", "an HTTP stream says what is not so of its parts",
        {field_at<&BadPart::mode>({.name = "mode",
                                   .doc = "length: Content-Length is half as large again as the picture; boundary: the "
                                          "line between it and the next part is missing"}),
         share_at<&BadPart::probability>("probability", "of each part")});
    to.add<CorruptVideo>(
        "corrupt_video", "H.264 and H.265 in streams is damaged",
        {field_at<&CorruptVideo::mode>(
             {.name = "mode",
              .doc = "bitflip: bits behind the headers of slices; drop_nal: slices are missing; drop_idr: those of key "
                     "frames are, so that readers wait or smear until the next"}),
         field_at<&CorruptVideo::amount>(
             {.name = "amount", .doc = "bitflip: flips in each slice that is hit", .range = {1, 1'000'000}}),
         share_at<&CorruptVideo::probability>("probability", "of each slice, with drop_idr of each key frame")});
    to.add<BufferError>("buffer_error", "user-space devices give buffers with V4L2_BUF_FLAG_ERROR, as vivid injects it",
                        {share_at<&BufferError::probability>("probability", "of each frame")});
    to.add<WrongSize>("wrong_size", "user-space devices give fewer bytes (bytesused) than the format says",
                      {share_at<&WrongSize::share>("share", "of the picture's bytes that are missing at its end"),
                       share_at<&WrongSize::probability>("probability", "of each frame")});
    to.add<DeviceError>(
        "device_error", "calls of user-space devices fail, as vivid injects it",
        {field_at<&DeviceError::at>({.name = "at",
                                     .doc = "reqbufs, qbuf, streamon: that ioctl gives EINVAL; streaming: queueing and "
                                            "dequeueing give EIO, until STREAMOFF"}),
         period_at<&DeviceError::period_s>(share_of_period)});
    to.add<Unplug>(
        "unplug", "user-space devices go, with their nodes, and come back after it",
        {period_at<&Unplug::period_s>(share_of_period),
         field_at<&Unplug::as_number>(
             {.name = "as_number", .doc = "the number it comes back under; -1: the same", .range = {-1, 255}}),
         field_at<&Unplug::replug_resets_controls>(
             {.name = "replug_resets_controls", .doc = "it comes back with the defaults of its image controls"})});
}

Kinds make_kinds() {
    Kinds made;
    add_body_kinds(made);
    add_optics_kinds(made);
    add_sensor_kinds(made);
    add_driver_kinds(made);
    add_transport_kinds(made);
    CHECK(made.kinds.size() == std::variant_size_v<FaultKind>);
    return made;
}

const Kinds& all_kinds() {
    static const Kinds kinds = make_kinds();
    return kinds;
}

}  // namespace

const std::vector<Kind<FaultKind>>& fault_kinds() {
    return all_kinds().kinds;
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
    return all_kinds().writers[kind.index()](kind);
}

}  // namespace camrig::fault
