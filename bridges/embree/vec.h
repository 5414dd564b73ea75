// SPDX-License-Identifier: Apache-2.0
// Inside the renderer: vectors of three floats, also used as linear RGB.
#ifndef BRIDGES_EMBREE_VEC_H
#define BRIDGES_EMBREE_VEC_H

#include <cmath>

namespace knr
{

constexpr float pi = 3.14159265f;

struct vec {
    float x, y, z;
};

inline vec operator+(vec a, vec b)
{
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline vec operator-(vec a, vec b)
{
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline vec operator*(vec a, vec b)
{
    return {a.x * b.x, a.y * b.y, a.z * b.z};
}
inline vec operator*(float s, vec a)
{
    return {s * a.x, s * a.y, s * a.z};
}
inline vec operator-(vec a)
{
    return {-a.x, -a.y, -a.z};
}
inline float dot(vec a, vec b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline vec cross(vec a, vec b)
{
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline vec normalize(vec a)
{
    float n = std::sqrt(dot(a, a));
    return n > 0.0f ? (1.0f / n) * a : vec{0.0f, 0.0f, 1.0f};
}
inline vec mix(vec a, vec b, float t)
{
    return (1.0f - t) * a + t * b;
}
inline float luminance(vec c)
{
    return 0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z;
}
inline float clamp(float x, float lo, float hi)
{
    return x > lo ? (x < hi ? x : hi) : lo; // lo when x is not a number
}
inline float smoothstep(float lo, float hi, float x)
{
    float t = clamp((x - lo) / (hi - lo), 0.0f, 1.0f);
    return t * t * (3.0f - 2.0f * t);
}

// Tangents of a unit normal. Source: Duff et al., Building an Orthonormal Basis, Revisited, JCGT 6(1), 2017.
struct frame {
    vec s, t, n;
    explicit frame(vec normal) : s{}, t{}, n(normal)
    {
        float sign = std::copysign(1.0f, n.z), a = -1.0f / (sign + n.z), b = n.x * n.y * a;
        s = {1.0f + sign * n.x * n.x * a, sign * b, -sign * n.x};
        t = {b, sign + n.y * n.y * a, -n.y};
    }
    vec to_world(vec v) const
    {
        return v.x * s + v.y * t + v.z * n;
    }
    vec to_local(vec v) const
    {
        return {dot(v, s), dot(v, t), dot(v, n)};
    }
};

} // namespace knr

#endif
