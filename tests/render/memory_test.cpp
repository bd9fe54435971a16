#include <gtest/gtest.h>

#include "core/render/composed_renderer.h"
#include "core/render/gl/gpu_model.h"
#include "core/render/gl/readback.h"
#include "core/render/gl/stream_buffer.h"
#include "core/render/null_renderer.h"
#include "tests/render/support/test_rig.h"

namespace camrig::render {
namespace {

/// Colours and depth: on the device cpu one is drawn by camrig's rasteriser and the other by Mesa's, each of which
/// keeps what it made of a model.
void draw_by_all(const world::SnapshotRef& snapshot) {
    View view = TestCamera{}.view();
    view.kinds[static_cast<int>(frame::FrameKind::color)] = true;
    view.kinds[static_cast<int>(frame::FrameKind::depth)] = true;
    EXPECT_EQ(draw_views(snapshot, {&view, 1}).size(), 2u);
}

world::SnapshotRef world_of(const world::ModelRef& still, const world::ModelRef& moving) {
    TestWorld world;
    world.objects = {instance_of(still, {5, 0, 0}, 1)};
    world.movers = {instance_of(moving, {4, 1, 0}, 2)};
    return world.snapshot();
}

TEST(Memory, ModelsOfAWorldThatIsGoneAreFreedThoughBothRasterisersDrewThem) {
    std::weak_ptr<const world::Model> still, moving;
    {
        const world::ModelRef a = model_of(box(glm::vec3(0.5f)), colored({1, 0, 0}));
        const world::ModelRef b = model_of(box(glm::vec3(0.3f)), colored({0, 1, 0}));
        still = a;
        moving = b;
        draw_by_all(world_of(a, b));
    }
    const world::ModelRef other = model_of(box(glm::vec3(0.4f)), colored({0, 0, 1}));
    draw_by_all(world_of(other, other));
    EXPECT_TRUE(still.expired());
    EXPECT_TRUE(moving.expired());
}

// Of a machine with a GPU: our rasteriser has cameras with a sensor alone.
TEST(Memory, AWorldIsLetGoWithTheLastCameraThatOurRasteriserDraws) {
    const auto pool = std::make_shared<frame::FramePool>();
    ComposedRenderer renderer({.pool = pool, .static_layer_bytes = 1 << 24}, std::make_unique<NullRenderer>(pool));
    const world::ModelRef still = model_of(box(glm::vec3(0.5f)), colored({1, 0, 0}));
    const View plain = TestCamera{}.view(1);
    View sensing = TestCamera{}.view(2);
    auto with_sensor = std::make_shared<world::CameraSpec>(*sensing.spec);
    with_sensor->sensor.emplace();
    sensing.spec = with_sensor;
    View sensing_no_more = TestCamera{}.view(2);
    sensing_no_more.spec_revision = sensing.spec_revision + 1;
    const auto is_held_after = [&](const auto& what_happens) {
        world::SnapshotRef moment = world_of(still, still);
        const std::weak_ptr<const world::Snapshot> watched = moment;
        EXPECT_TRUE(renderer.draw(moment, 0, std::vector{plain, sensing}));
        moment.reset();
        what_happens();
        return !watched.expired();
    };
    EXPECT_TRUE(is_held_after([] {})) << "for the camera's next picture";
    EXPECT_TRUE(is_held_after([&] { renderer.forget(plain.camera); }));
    EXPECT_FALSE(is_held_after([&] { renderer.forget(sensing.camera); }));
    EXPECT_FALSE(is_held_after([&] { renderer.hand_over(sensing.camera); }));
    EXPECT_FALSE(is_held_after(
        [&] { EXPECT_TRUE(renderer.draw(world_of(still, still), 0, std::vector{plain, sensing_no_more})); }));
    EXPECT_FALSE(is_held_after([&] { EXPECT_TRUE(renderer.draw(world_of(still, still), 0, {})); }))
        << "there is another world";
}

/// A device that gives buffers, but no memory for them.
gl::GlFunctions exhausted_device() {
    gl::GlFunctions gl;
    gl.GetIntegerv = [](GLenum, GLint* value) { *value = 256; };
    gl.CreateBuffers = [](GLsizei, GLuint* name) { *name = 1; };
    gl.DeleteBuffers = [](GLsizei, const GLuint*) {};
    gl.NamedBufferStorage = [](GLuint, GLsizeiptr, const void*, GLbitfield) {};
    gl.MapNamedBufferRange = [](GLuint, GLintptr, GLsizeiptr, GLbitfield) -> void* { return nullptr; };
    return gl;
}

// GlRenderer::draw makes an error of it, which ends the request that wanted the picture.
TEST(Memory, ADeviceWithoutMemoryIsAnExceptionAndNotTheEndOfTheProgram) {
    const gl::GlFunctions gl = exhausted_device();
    gl::StreamBuffer stream(gl);
    EXPECT_THROW(stream.allocate(100), std::bad_alloc);
    EXPECT_EQ(stream.capacity(), 0u);
    gl::ReadbackBuffer readback(gl);
    EXPECT_THROW(readback.reset(100), std::bad_alloc);
    EXPECT_THROW(readback.reset(100), std::bad_alloc);  // and no room is taken for granted afterwards
}

/// Errors that the device has noted, the first one last.
std::vector<GLenum> noted;

/// A device that takes what it is given, and whose memory is out at the first vertices.
gl::GlFunctions device_of_little_memory() {
    gl::GlFunctions gl = exhausted_device();
    gl.GetError = []() -> GLenum {
        if (noted.empty()) return GL_NO_ERROR;
        const GLenum code = noted.back();
        noted.pop_back();
        return code;
    };
    gl.CreateVertexArrays = [](GLsizei, GLuint* name) { *name = 1; };
    gl.DeleteVertexArrays = [](GLsizei, const GLuint*) {};
    gl.VertexArrayElementBuffer = [](GLuint, GLuint) {
        noted = {GL_OUT_OF_MEMORY, GL_INVALID_OPERATION};  // what follows from it is told too
    };
    gl.EnableVertexArrayAttrib = [](GLuint, GLuint) {};
    gl.VertexArrayAttribFormat = [](GLuint, GLuint, GLint, GLenum, GLboolean, GLuint) {};
    gl.VertexArrayAttribBinding = [](GLuint, GLuint, GLuint) {};
    gl.VertexArrayVertexBuffer = [](GLuint, GLuint, GLuint, GLintptr, GLsizei) {};
    return gl;
}

// The driver says so by an error that somebody must ask for.
TEST(Memory, AModelThatTheDeviceHasNoMemoryForIsAnException) {
    gl::GlFunctions gl = device_of_little_memory();
    gl::SamplerCache samplers(gl);
    const world::ModelRef model = model_of(box(glm::vec3(0.5f)), colored({1, 0, 0}));
    EXPECT_THROW(upload_model(gl, samplers, *model, scene::prepare_model(model)), std::bad_alloc);
    EXPECT_TRUE(noted.empty()) << "another model would be blamed";
    gl.VertexArrayElementBuffer = [](GLuint, GLuint) {};
    EXPECT_NO_THROW(upload_model(gl, samplers, *model, scene::prepare_model(model)));
}

}  // namespace
}  // namespace camrig::render
