// A picture in another layout (core/frame/convert.h), four of its bytes an invocation. Integers all the way
// (core/frame/yuv_matrix.h): the bytes are those of the CPU.
layout(local_size_x = GROUP_WORDS) in;
layout(binding = 0) uniform usampler2D picture;
layout(std430, binding = 0) restrict writeonly buffer Converted { uint words[]; };

ivec2 size = textureSize(picture, 0);
ivec2 half_size = (size + 1) / 2;

ivec3 pixel(int x, int y) {
    return ivec3(texelFetch(picture, min(ivec2(x, y), size - 1), 0).rgb);
}

uint inner(ivec3 factors, ivec3 rgb, int offset, int bits) {
    return uint((factors.r * rgb.r + factors.g * rgb.g + factors.b * rgb.b + offset) >> bits);
}

uint luma(int x, int y) {
    return inner(Y_FACTORS, pixel(x, y), Y_OFFSET, Y_BITS);
}

// Of the pixels 2x and 2x + 1 in two rows.
uint chroma(ivec3 factors, int x, int row_0, int row_1) {
    ivec3 sum = pixel(2 * x, row_0) + pixel(2 * x + 1, row_0) + pixel(2 * x, row_1) + pixel(2 * x + 1, row_1);
    return inner(factors, sum, SUM_OFFSET, SUM_BITS);
}

uint chroma_of_plane(ivec3 factors, int i) {
    int y = i / half_size.x;
    return chroma(factors, i % half_size.x, 2 * y, 2 * y + 1);
}

uint byte_at(int i) {
#if defined(PACKED_24)
    return uint(pixel(i / 3 % size.x, i / 3 / size.x)[CHANNEL(i % 3)]);
#elif defined(YUYV)
    int row_bytes = 4 * half_size.x;
    int y = i / row_bytes, pair = i % row_bytes / 4;
    if (i % 2 == 0) return luma(2 * pair + i % 4 / 2, y);
    return chroma(i % 4 == 1 ? U_FACTORS : V_FACTORS, pair, y, y);
#else
    if (i < size.x * size.y) return luma(i % size.x, i / size.x);
    i -= size.x * size.y;
#if defined(NV12)
    return chroma_of_plane(i % 2 == 0 ? U_FACTORS : V_FACTORS, i / 2);
#else
    int plane = half_size.x * half_size.y;
    return i < plane ? chroma_of_plane(U_FACTORS, i) : chroma_of_plane(V_FACTORS, i - plane);
#endif
#endif
}

void main() {
    int word = int(gl_GlobalInvocationID.x + gl_GlobalInvocationID.y * gl_NumWorkGroups.x * GROUP_WORDS);
    if (word >= words.length()) return;
    uint bytes = 0u;
    for (int k = 0; k < 4; ++k) bytes |= byte_at(4 * word + k) << 8 * k;
    words[word] = bytes;
}
