#include <algorithm>
#include <array>

#include "control/unrealcv/session.h"
#include "control/unrealcv/units.h"
#include "core/truth/posed_object.h"
#include "core/world/turn.h"
#include "core/world/world_fields.h"

// Objects and actors: where they are, how masks show them, new ones, and what programs let actors do.
namespace camrig::unrealcv {
namespace asio = boost::asio;
namespace {

using Awaited = asio::awaitable<Answer>;

/// Of one object; their text is some 40 bytes each.
constexpr std::size_t max_vertices = 1'000'000;
/// Between the cameras of a StereoCameraActor, on either side.
constexpr double half_eye_distance_cm = 40.0;
constexpr int most_names_tried = 10'000;

glm::dvec3 vector_at(Arguments arguments, std::size_t first) {
    return {*number_of(arguments[first]), *number_of(arguments[first + 1]), *number_of(arguments[first + 2])};
}

Awaited list(Session& session, Arguments) {
    const auto now = co_await session.moment();
    if (!now) co_return refused(now.error());
    std::string names;
    for (const world::ObjectReport& one : objects_of((*now)->world()))
        (names += names.empty() ? "" : " ") += shown_name(one.name);
    co_return names;
}

using Tell = std::string (*)(const FoundObject&);
asio::awaitable<Answer> tell(Session& session, std::string_view name, Tell text) {
    const auto now = co_await session.moment();
    if (!now) co_return refused(now.error());
    const auto object = object_named(session.door(), **now, name);
    if (!object) co_return refused(object.error());
    co_return text(*object);
}

Awaited location(Session& session, Arguments arguments) {
    return tell(session, arguments[0],
                [](const auto& object) { return text_of(location_of(object.instance->position)); });
}
Awaited rotation(Session& session, Arguments arguments) {
    return tell(session, arguments[0], [](const auto& object) { return text_of(rotation_of(object.orientation())); });
}
Awaited scale(Session& session, Arguments arguments) {
    return tell(session, arguments[0], [](const auto& object) { return text_of(glm::dvec3(object.instance->scale)); });
}
Awaited mobility(Session& session, Arguments arguments) {
    return tell(session, arguments[0],
                [](const auto& object) { return std::string(object.moves ? "Movable" : "Static"); });
}
Awaited uclass_name(Session& session, Arguments arguments) {
    return tell(session, arguments[0], [](const auto& object) { return object.instance->info->object_class; });
}

Awaited color(Session& session, Arguments arguments) {
    const auto now = co_await session.moment();
    if (!now) co_return refused(now.error());
    const auto object = object_named(session.door(), **now, arguments[0]);
    if (!object) co_return refused(object.error());
    co_return text_of(session.door().colors->of(object->instance->info->id));
}

Awaited set_color(Session& session, Arguments arguments) {
    const auto now = co_await session.moment();
    if (!now) co_return refused(now.error());
    const auto object = object_named(session.door(), **now, arguments[0]);
    if (!object) co_return refused(object.error());
    Rgb wanted{};
    for (std::size_t i = 0; i < wanted.size(); ++i) {
        const int level = *integer_of(arguments[i + 1]);
        if (level > 255) co_return bad_arguments();
        wanted[i] = static_cast<std::uint8_t>(level);
    }
    // Pictures that are being made keep the colours that they began with.
    auto colors = std::make_shared<Colors>(*session.door().colors);
    colors->set(object->instance->info->id, wanted);
    session.door().colors = std::move(colors);
    co_return std::string();
}

/// Asks what moves as an actor, and what is none, or stands, as an object.
template <typename ForActor, typename ForObject>
asio::awaitable<Answer> change_one(Session& session, std::string_view name, ForActor for_actor, ForObject for_object) {
    const auto now = co_await session.moment();
    if (!now) co_return refused(now.error());
    const auto object = object_named(session.door(), **now, name);
    if (!object) co_return refused(object.error());
    const std::string real_name = object->name();
    if (object->moves) {
        auto command = for_actor(real_name);
        auto done = co_await session.ask(std::move(command));
        session.changed();
        if (done) co_return std::string();
        if (done.error().kind != ErrorKind::not_found) co_return refused(done.error().message);
    }
    auto command = for_object(real_name);
    co_return co_await session.change(std::move(command));
}

asio::awaitable<Answer> place(Session& session, std::string_view name, std::optional<glm::dvec3> position,
                              std::optional<glm::dquat> orientation) {
    const auto as_actor = [=](const std::string& of) {
        return engine::SetActor{{.name = of, .position = position, .orientation = orientation}};
    };
    const auto as_object = [=](const std::string& of) {
        return engine::SetObject{{.name = of, .position = position, .orientation = orientation}};
    };
    co_return co_await change_one(session, name, as_actor, as_object);
}

Awaited set_location(Session& session, Arguments arguments) {
    return place(session, arguments[0], metres_of(vector_at(arguments, 1)), std::nullopt);
}
Awaited set_rotation(Session& session, Arguments arguments) {
    return place(session, arguments[0], std::nullopt, orientation_of(vector_at(arguments, 1)));
}

/// What camrig says of objects and actors alike.
asio::awaitable<Answer> set(Session& session, std::string_view name, world::ObjectPatch patch) {
    const auto now = co_await session.moment();
    if (!now) co_return refused(now.error());
    const auto object = object_named(session.door(), **now, name);
    if (!object) co_return refused(object.error());
    patch.name = object->name();
    engine::SetObject command{std::move(patch)};
    co_return co_await session.change(std::move(command));
}

Awaited show(Session& session, Arguments arguments) {
    return set(session, arguments[0], {.name = {}, .hidden = false});
}
Awaited hide(Session& session, Arguments arguments) {
    return set(session, arguments[0], {.name = {}, .hidden = true});
}
Awaited set_scale(Session& session, Arguments arguments) {
    const glm::dvec3 wanted = vector_at(arguments, 1);
    const auto refuse = [](std::string why) -> asio::awaitable<Answer> { co_return refused(std::move(why)); };
    if (wanted.x != wanted.y || wanted.x != wanted.z)
        return refuse("an object of camrig has one scale for all axes; give the same three times");
    if (!(wanted.x >= 1e-6 && wanted.x <= 1e6)) return refuse("a scale is from 0.000001 to 1000000");
    return set(session, arguments[0], {.name = {}, .scale = wanted.x});
}

Awaited destroy(Session& session, Arguments arguments) {
    const auto now = co_await session.moment_of_cameras();
    if (!now) co_return refused(now.error());
    // Cameras are objects too in UnrealCV.
    const auto camera = std::ranges::find((*now)->cameras, arguments[0],
                                          [](const auto& one) { return std::string_view(one.camera.spec()->name); });
    if (!object_named(session.door(), **now, arguments[0]) && camera != (*now)->cameras.end()) {
        engine::DeleteCamera command{camera->camera.spec()->name};
        co_return co_await session.change(std::move(command));
    }
    const auto as_actor = [](const std::string& of) { return engine::RemoveActor{of}; };
    const auto as_object = [](const std::string& of) { return engine::RemoveObject{of}; };
    co_return co_await change_one(session, arguments[0], as_actor, as_object);
}

/// The vertices of an object in the world, by UnrealCV's units.
template <typename Use>
Result<void> for_each_vertex(const world::Instance& instance, Use&& use) {
    truth::PosedObject posed;
    posed.pose(instance);
    posed.place_vertices();
    std::size_t count = 0;
    for (const auto& part : posed.parts()) count += part.points.size();
    if (count > max_vertices)
        return error(ErrorKind::resource_exhausted,
                     "an object of " + std::to_string(count) + " vertices; at most " + std::to_string(max_vertices));
    for (const auto& part : posed.parts())
        for (const glm::dvec3& point : part.points) use(location_of(posed.position() + posed.orientation() * point));
    return {};
}

Result<std::string> vertices_text(const world::Instance& instance) {
    std::string text;
    auto done = for_each_vertex(instance, [&](const glm::dvec3& v) {
        if (!text.empty()) text += '\n';
        text += text_of(v, 5, "     ");
    });
    return done ? Result<std::string>(std::move(text)) : std::unexpected(done.error());
}

Result<std::string> bounds_text(const world::Instance& instance) {
    glm::dvec3 least(std::numeric_limits<double>::infinity()), most(-least);
    auto done = for_each_vertex(instance, [&](const glm::dvec3& v) {
        least = glm::min(least, v);
        most = glm::max(most, v);
    });
    if (!done) return std::unexpected(done.error());
    if (least.x > most.x) least = most = location_of(instance.position);
    return text_of(least, 2) + " " + text_of(most, 2);
}

asio::awaitable<Answer> measure(Session& session, std::string_view name,
                                Result<std::string> (*text)(const world::Instance&)) {
    const auto now = co_await session.moment();
    if (!now) co_return refused(now.error());
    const auto object = object_named(session.door(), **now, name);
    if (!object) co_return refused(object.error());
    std::function<Result<std::string>()> make = [text, one = *object->instance] { return text(one); };
    auto made = co_await session.work(std::move(make));
    if (!made) co_return refused(made.error().message);
    co_return std::move(*made);
}

Awaited vertex_location(Session& session, Arguments arguments) {
    return measure(session, arguments[0], vertices_text);
}
Awaited bounds(Session& session, Arguments arguments) {
    return measure(session, arguments[0], bounds_text);
}

/// The class that others of this model have.
std::string class_of(const world::Scene& scene, const std::string& model) {
    for (const world::ActorSpec& one : scene.actors)
        if (one.model == model) return one.object_class;
    for (const world::ObjectSpec& one : scene.objects)
        if (one.model == model) return one.object_class;
    return model;
}

asio::awaitable<Answer> spawn_stereo(Session& session, glm::dvec3 to) {
    auto left = co_await spawn_camera(session, to - glm::dvec3(0.0, half_eye_distance_cm, 0.0));
    if (!left) co_return left;
    auto right = co_await spawn_camera(session, to + glm::dvec3(0.0, half_eye_distance_cm, 0.0));
    if (!right) {
        // Nobody has been told its name. The command has one here: of a temporary in a co_await GCC 12 frees the string
        // twice.
        engine::DeleteCamera command{std::string(left->bytes())};
        std::ignore = co_await session.ask(std::move(command));
        co_return right;
    }
    std::string names(left->bytes());
    co_return names.append(" ").append(right->bytes());
}

asio::awaitable<Answer> spawn_model(Session& session, std::string of_class, std::string name, glm::dvec3 to) {
    const auto now = co_await session.moment();
    if (!now) co_return refused(now.error());
    const world::Scene& scene = *(*now)->instant->scene;
    std::string model = of_class;
    if (!scene.models.contains(model) && model.ends_with("_C")) model.resize(model.size() - 2);
    if (!scene.models.contains(model)) co_return refused("Can not find a class with name '" + of_class + "'");
    if (!name.empty() && (!world::is_scene_name(name) || shown_name(name) != name))
        co_return refused("a name is of 1 to 64 printable characters, none of them a space or a slash");
    if (!name.empty() && object_named(session.door(), **now, name))
        co_return refused("Failed to spawn " + name + ", object exists.");
    for (int i = 0; name.empty() && i < most_names_tried; ++i) {
        std::string free = of_class + "_" + std::to_string(i);
        if (!object_named(session.door(), **now, free)) name = std::move(free);
    }
    engine::SpawnActor command;
    command.actor.name = name;
    command.actor.object_class = class_of(scene, model);
    command.actor.model = model;
    command.actor.position = metres_of(to);
    command.actor.behaviour = world::StandBehaviour{};
    auto done = co_await session.change(std::move(command));
    if (!done) co_return done;
    co_return name;
}

asio::awaitable<Answer> spawn_one(Session& session, std::string_view of_class, std::string_view name, glm::dvec3 to) {
    if (of_class == "FusionCameraActor") return spawn_camera(session, to);
    if (of_class == "StereoCameraActor") return spawn_stereo(session, to);
    return spawn_model(session, std::string(of_class), std::string(name), to);
}

Awaited spawn(Session& session, Arguments arguments) {
    return spawn_one(session, arguments[0], {}, {});
}
Awaited spawn_named(Session& session, Arguments arguments) {
    return spawn_one(session, arguments[0], arguments[1], {});
}
Awaited spawn_placed(Session& session, Arguments arguments) {
    return spawn_one(session, arguments[0], arguments[1], vector_at(arguments, 2));
}
Awaited spawn_cube(Session& session, Arguments) {
    return spawn_one(session, "cube", {}, {});
}
Awaited spawn_named_cube(Session& session, Arguments arguments) {
    return spawn_one(session, "cube", arguments[0], {});
}

// Functions of blueprints, as UnrealZoo and SimWorld call them to move their agents.

/// Turns an actor by an angle to the right, and lets it go ahead at a speed until it is told otherwise.
asio::awaitable<Answer> set_move(Session& session, const FoundObject& actor, double degrees, double cm_s) {
    const double yaw = world::yaw_of(actor.orientation()) - glm::radians(degrees);
    world::SteerSpec steer{.name = actor.name(), .yaw_rad = yaw};
    steer.velocity = cm_s / 100.0 * glm::dvec3(std::cos(yaw), std::sin(yaw), 0.0);
    return session.change(engine::SteerActors{{std::move(steer)}});
}

asio::awaitable<Answer> nav_to_goal(Session& session, const FoundObject& actor, glm::dvec3 to) {
    const world::Model& model = *actor.instance->info->model;
    world::GoToBehaviour going;
    going.position = metres_of(to);
    if (model.find_animation("walk") >= 0) going.walk.clip = "walk";
    if (model.find_animation("wait") >= 0) going.walk.idle_clip = "wait";
    return session.change(engine::SetActor{{.name = actor.name(), .behaviour = std::move(going)}});
}

/// The words of an argument list, at most so many as functions have.
std::vector<std::string_view> words_of(std::string_view text) {
    std::vector<std::string_view> words;
    while (!text.empty() && words.size() < 16) {
        const std::size_t end = std::min(text.find(' '), text.size());
        if (end > 0) words.push_back(text.substr(0, end));
        text.remove_prefix(std::min(end + 1, text.size()));
    }
    return words;
}

Awaited blueprint(Session& session, Arguments arguments) {
    const auto now = co_await session.moment();
    if (!now) co_return refused(now.error());
    const auto object = object_named(session.door(), **now, arguments[0]);
    if (!object) co_return refused(object.error());
    const auto words = words_of(arguments[1]);
    std::vector<double> numbers;
    for (std::size_t i = 1; i < words.size(); ++i)
        if (const auto number = number_of(words[i])) numbers.push_back(*number);
    const bool are_numbers = numbers.size() + 1 == words.size();
    const std::string_view function = words.empty() ? std::string_view() : words.front();
    Answer done = refused("Not Implemented");
    if (function == "set_move" && are_numbers && numbers.size() == 2) {
        done = co_await set_move(session, *object, numbers[0], numbers[1]);
    } else if (function == "nav_to_goal" && are_numbers && numbers.size() == 3) {
        done = co_await nav_to_goal(session, *object, {numbers[0], numbers[1], numbers[2]});
    }
    // A function without values to give.
    if (done) done = std::string("{}");
    co_return done;
}

}  // namespace

std::span<const Command> object_commands() {
    static constexpr std::array table{
        Command{"vget /objects", "Names of all objects and actors", list},
        Command{"vset /objects/spawn_cube", "Spawns the scene's model cube", spawn_cube},
        Command{"vset /objects/spawn_cube [str]", "The same with a name", spawn_named_cube},
        Command{"vset /objects/spawn [str]", "Spawns a model of the scene, or cameras", spawn},
        Command{"vset /objects/spawn [str] [str]", "The same with a name", spawn_named},
        Command{"vset /objects/spawn [str] [str] [float] [float] [float]", "The same at x y z", spawn_placed},
        Command{"vget /object/[str]/location", "Where it is: x y z, centimetres", location},
        Command{"vset /object/[str]/location [float] [float] [float]", "Puts it to x y z", set_location},
        Command{"vget /object/[str]/rotation", "How it is turned: pitch yaw roll, degrees", rotation},
        Command{"vset /object/[str]/rotation [float] [float] [float]", "Turns it to pitch yaw roll", set_rotation},
        Command{"vget /object/[str]/scale", "Its scale, three times", scale},
        Command{"vset /object/[str]/scale [float] [float] [float]", "Sets it; all three alike", set_scale},
        Command{"vget /object/[str]/bounds", "Its box in the world: least x y z, greatest x y z", bounds},
        Command{"vget /object/[str]/color", "Its colour in object_mask", color},
        Command{"vset /object/[str]/color [uint] [uint] [uint]", "Sets it", set_color},
        Command{"vget /object/[str]/mobility", "Movable or Static", mobility},
        Command{"vget /object/[str]/uclass_name", "Its class in ground truth", uclass_name},
        Command{"vget /object/[str]/vertex_location", "Its vertices in the world, one a line", vertex_location},
        Command{"vget /object/[str]/vertices", "The same as vertex_location", vertex_location},
        Command{"vset /object/[str]/show", "Shows it", show},
        Command{"vset /object/[str]/hide", "Hides it", hide},
        Command{"vset /object/[str]/destroy", "Removes it; of a camera's name, the camera", destroy},
        Command{"vbp [str] [rest]", "set_move ANGLE SPEED, nav_to_goal X Y Z", blueprint}};
    return table;
}

}  // namespace camrig::unrealcv
