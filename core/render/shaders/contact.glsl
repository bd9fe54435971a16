// What bodies keep of the light from all around (core/render/scene/body_capsules.h).
#ifdef GGX
struct Capsule {
    vec4 from;   // w: radius
    vec4 along;  // to the other end; w: its length
};
struct Body {
    vec4 ball;   // in which it keeps light from things: middle, square of the radius
    uvec4 what;  // object, first capsule, how many, whether it moves
};
layout(std430, binding = 0) readonly buffer BodyBlock { Body bodies[]; };
layout(std430, binding = 1) readonly buffer CapsuleBlock { Capsule capsules[]; };

// Share of the light of an even hemisphere over a surface with normal n that a capsule hides. The ball that is nearest
// hides (Oat and Sander, Ambient Aperture Lighting, 2007) or, if that is more, the line, as wide as it is (Heitz and
// Hill, Real-Time Line- and Disk-Light Shading, SIGGRAPH 2017 courses), and half of the ball for its ends. Fades away
// towards its reach.
float hidden_share(Capsule c, vec3 position, vec3 n) {
    float radius = c.from.w, radius2 = radius * radius, reach = radius + CONTACT_REACH;
    vec3 from = c.from.xyz - position;
    vec3 towards = from + c.along.xyz * clamp(-dot(from, c.along.xyz) / max(c.along.w * c.along.w, 1e-12), 0.0, 1.0);
    float distance2 = dot(towards, towards);
    float fade = clamp(1.0 - distance2 / (reach * reach), 0.0, 1.0);
    if (fade == 0.0) return 0.0;
    distance2 = max(distance2, radius2);
    float ball = max(dot(towards, n), 0.0) * inversesqrt(distance2) * (radius2 / distance2);

    // The line in a frame about the point, cut at the horizon: along `unit` from first to last, beside it by d.
    vec3 unit = c.along.xyz / max(c.along.w, 1e-6);
    float start = dot(from, unit), end = start + c.along.w;
    vec3 beside = from - unit * start;
    float d = max(length(beside), radius);
    float height = dot(beside, n), slope = dot(unit, n);
    float horizon = -height / (slope > 0.0 ? max(slope, 1e-6) : min(slope, -1e-6));
    float first = slope > 0.0 ? min(max(start, horizon), end) : start;
    float last = slope > 0.0 ? end : max(min(end, horizon), start);
    float first2 = d * d + first * first, last2 = d * d + last * last;
    float angle = atan(d * (last - first), d * d + first * last);
    float line = height * (last / last2 - first / first2 + angle / d) / d + slope * (d / first2 - d / last2);
    return clamp(max(ball, 0.5 * ball + line * radius * 0.31830989), 0.0, 1.0) * (fade * fade);
}

// Share of the light from all around that bodies leave to a point of an object.
float open_share(uint object, vec3 position, vec3 n) {
    float open = 1.0;
    for (uint b = 0u; b < uint(view.bodies.x); ++b) {
        vec3 away = bodies[b].ball.xyz - position;
        uvec4 what = bodies[b].what;
        if (what.x == object || dot(away, away) >= bodies[b].ball.w) continue;
        for (uint i = what.y; i < what.y + what.z; ++i) open *= 1.0 - hidden_share(capsules[i], position, n);
    }
    return open;
}
#endif
