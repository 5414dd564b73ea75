// SPDX-License-Identifier: Apache-2.0
// Inside the renderer: the lights, the dome, the backdrop and the film. The object is centred at the origin with
// radius 1; x points to the camera's right, y away from it, z up.
#ifndef BRIDGES_EMBREE_STUDIO_H
#define BRIDGES_EMBREE_STUDIO_H

#include "bridges/embree/sampler.h"
#include "bridges/embree/vec.h"

namespace knr
{

// A rectangle with soft edges that shines to the side of n.
struct softbox {
    vec centre, s, t, n; // s, t: half sides
    vec radiance;
    float area, power;
};

enum { LIGHTS = 5 };

struct studio {
    softbox light[LIGHTS];
    float exposure;
};

inline softbox make_softbox(vec centre, vec target, float width, float height, vec radiance)
{
    softbox b = {};
    b.centre = centre, b.radiance = radiance;
    b.n = normalize(target - centre);
    vec across = normalize(cross(b.n, vec{0.0f, 0.0f, 1.0f}));
    b.s = (0.5f * width) * across;
    b.t = (0.5f * height) * cross(across, b.n);
    b.area = width * height;
    return b;
}

// Key: large, warm, high on the left. Fill: low and cool on the right. Two strips behind draw the contours, and an
// overhead box gives every upward face a highlight.
inline studio make_studio(float exposure)
{
    studio st = {};
    const vec warm = {1.0f, 0.93f, 0.84f}, cool = {0.84f, 0.93f, 1.0f}, white = {1.0f, 0.98f, 0.96f};
    const vec low = {0.0f, 0.0f, -0.1f};
    st.light[0] = make_softbox({-3.5f, -1.5f, 3.3f}, low, 2.4f, 2.4f, 17.0f * warm);
    st.light[1] = make_softbox({3.9f, -2.6f, 1.4f}, low, 2.4f, 3.0f, 1.8f * cool);
    st.light[2] = make_softbox({2.8f, 3.0f, 2.4f}, low, 1.0f, 3.2f, 12.0f * white);
    st.light[3] = make_softbox({-3.2f, 3.0f, 1.6f}, low, 0.8f, 3.0f, 6.0f * cool);
    st.light[4] = make_softbox({0.2f, 0.6f, 4.0f}, low, 3.0f, 1.8f, 5.0f * white);
    for (softbox &b : st.light) {
        b.radiance = exposure * b.radiance;
        b.power = b.area * luminance(b.radiance);
    }
    st.exposure = exposure;
    return st;
}

// The room: dark above, brighter towards the horizon, a little cooler at the right.
inline vec dome(const studio &st, vec d)
{
    float up = clamp(d.z, 0.0f, 1.0f), side = 0.5f + 0.5f * d.x;
    vec horizon = mix({0.42f, 0.38f, 0.34f}, {0.28f, 0.30f, 0.33f}, side);
    return st.exposure * mix(horizon, {0.10f, 0.10f, 0.11f}, smoothstep(0.0f, 0.7f, up));
}
constexpr float dome_irradiance = 0.55f; // of an open level place, about: the integral of dome(d) d.z

// 0 .. 1 over the box: full in the middle, fading in the outer quarter.
inline float softbox_profile(float u, float v)
{
    return (1.0f - smoothstep(0.7f, 1.0f, std::fabs(u))) * (1.0f - smoothstep(0.7f, 1.0f, std::fabs(v)));
}

// The probability with which a place asks each box: about its share of the light there. 0 where none can come.
struct choice {
    float probability[LIGHTS];
};

inline choice choose_lights(const studio &st, vec from, vec normal)
{
    choice out;
    float sum = 0.0f;
    for (int i = 0; i < LIGHTS; i++) {
        const softbox &b = st.light[i];
        vec d = b.centre - from;
        float squared = dot(d, d), distance = std::sqrt(squared);
        float there = -dot(d, b.n) / distance, here = (dot(d, normal) / distance + 0.4f) / 1.4f; // boxes are broad
        out.probability[i] = there > 0.0f && here > 0.0f ? b.power * there * here / squared : 0.0f;
        sum += out.probability[i];
    }
    for (float &p : out.probability) p = sum > 0.0f ? p / sum : 0.0f;
    return out;
}

struct light_sample {
    vec to; // unit
    float distance, density;
    vec radiance;
};

// density is per solid angle, the choice of the box included; 0: no light from here.
inline light_sample sample_light(const studio &st, const choice &of, vec from, float select, point2 at)
{
    int i = 0;
    for (; i < LIGHTS - 1 && select >= of.probability[i]; i++) select -= of.probability[i];
    const softbox &b = st.light[i];
    float u = 2.0f * at.x - 1.0f, v = 2.0f * at.y - 1.0f;
    vec d = b.centre + u * b.s + v * b.t - from;
    float squared = dot(d, d), distance = std::sqrt(squared);
    vec to = (1.0f / distance) * d;
    float cosine = -dot(to, b.n);
    if (!(cosine > 1e-4f)) return {to, distance, 0.0f, {0.0f, 0.0f, 0.0f}};
    return {to, distance, of.probability[i] * squared / (b.area * cosine), softbox_profile(u, v) * b.radiance};
}

// The radiance of the boxes that a ray meets before `far`, each weighted against sample_light by the balance
// heuristic: density is the ray's own. of is NULL where sample_light is not used.
inline vec lights_along(const studio &st, const choice *of, vec from, vec d, float far, float density)
{
    vec sum = {0.0f, 0.0f, 0.0f};
    for (int i = 0; i < LIGHTS; i++) {
        const softbox &b = st.light[i];
        float cosine = -dot(d, b.n);
        if (!(cosine > 1e-4f)) continue;
        float distance = dot(from - b.centre, b.n) / cosine;
        if (!(distance > 0.0f && distance < far)) continue;
        vec at = from + distance * d - b.centre;
        float u = dot(at, b.s) / dot(b.s, b.s), v = dot(at, b.t) / dot(b.t, b.t);
        if (std::fabs(u) >= 1.0f || std::fabs(v) >= 1.0f) continue;
        float other = of ? of->probability[i] * distance * distance / (b.area * cosine) : 0.0f;
        sum = sum + (density / (density + other) * softbox_profile(u, v)) * b.radiance;
    }
    return sum;
}

// The backdrop where nothing stands, in linear display values: x, y in [-1,1] over the picture, y up.
inline vec backdrop(float x, float y)
{
    float r = std::sqrt(0.55f * x * x + 0.7f * (y + 0.15f) * (y + 0.15f));
    return mix({0.62f, 0.63f, 0.64f}, {0.16f, 0.175f, 0.20f}, smoothstep(0.1f, 1.3f, r));
}

// Keeps hues, and lets what is too bright run to white. Source: Khronos PBR Neutral Tone Mapper, 2024.
inline vec film(vec c)
{
    const float start = 0.8f - 0.04f, d = 1.0f - start;
    float least = c.x < c.y ? (c.x < c.z ? c.x : c.z) : (c.y < c.z ? c.y : c.z);
    float offset = least < 0.08f ? least - 6.25f * least * least : 0.04f;
    c = c - vec{offset, offset, offset};
    float peak = c.x > c.y ? (c.x > c.z ? c.x : c.z) : (c.y > c.z ? c.y : c.z);
    if (peak < start) return c;
    float top = 1.0f - d * d / (peak + d - start), white = 1.0f - 1.0f / (0.15f * (peak - top) + 1.0f);
    return mix((top / peak) * c, {top, top, top}, white);
}

// Source: IEC 61966-2-1.
inline float encode_srgb(float x)
{
    return x <= 0.0031308f ? 12.92f * x : 1.055f * std::pow(x, 1.0f / 2.4f) - 0.055f;
}

} // namespace knr

#endif
