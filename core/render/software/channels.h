#pragma once

#include "core/render/software/view_work.h"

/// The pictures of a view that are no colour: depth, ids, classes, normals and optical flow of what is opaque, at the
/// middle of each pixel. They come of the triangles that find_visible found: one pass gives them together with colour.
///
/// In each band of rows: begin_channels; describe_visible of what stands still, then keep_channels if there is a layer
/// to be made; describe_visible of what moves. Different bands from different threads.
namespace camrig::render::software {

/// 32-bit words of a pixel.
constexpr int words_of(frame::FrameKind kind) {
    if (kind == frame::FrameKind::flow) return 2;
    return kind == frame::FrameKind::normal ? 3 : 1;
}

/// The size of a plane that holds such a picture, in words.
inline ImageSize words_of(frame::FrameKind kind, ImageSize size) {
    return {words_of(kind) * size.width, size.height};
}

inline constexpr std::array channel_kinds{frame::FrameKind::depth, frame::FrameKind::instance,
                                          frame::FrameKind::semantic, frame::FrameKind::normal, frame::FrameKind::flow};

/// What the draws of a view say of the objects they belong to: for describe_visible.
void name_draws(ViewScratch& scratch);

/// Nothing is there yet, or what the layer keeps.
void begin_channels(ViewWork& work, const PixelRect& band);

/// Writes what shows in the pixels of the rectangle that have a triangle. Their numbers stay.
void describe_visible(const ViewScratch& scratch, const PixelRect& rect, ViewWork& work);

/// What is drawn so far is what stands still.
void keep_channels(ViewWork& work, const PixelRect& band);

/// Draws a band of a view whose colour is not wanted, and what of it a layer keeps.
void draw_channel_rows(ViewWork& work, const ViewScratch& scratch, const PixelRect& band);

}  // namespace camrig::render::software
