// SPDX-License-Identifier: Apache-2.0
// Inside the renderer: the metallic-roughness material, a GGX coat over a diffuse base. Directions are unit vectors
// in the shading frame (normal = z), both pointing away from the surface.
// Source: Walter et al. 2007; Heitz, Sampling the GGX distribution of visible normals, JCGT 7(4), 2018; Schlick 1994.
#ifndef BRIDGES_EMBREE_MATERIAL_H
#define BRIDGES_EMBREE_MATERIAL_H

#include "bridges/embree/sampler.h"
#include "bridges/embree/vec.h"

namespace knr
{

struct surface {
    vec diffuse, f0;
    float alpha;
    // A narrow lobe alone is sampled better by itself than by points of the lights.
    bool narrower(float than) const
    {
        return alpha < than && diffuse.x + diffuse.y + diffuse.z < 0.02f;
    }
};

inline vec fresnel(vec f0, float cosine)
{
    float m = clamp(1.0f - cosine, 0.0f, 1.0f), m2 = m * m;
    return f0 + (m2 * m2 * m) * (vec{1.0f, 1.0f, 1.0f} - f0);
}

inline float ggx_lambda(float alpha, vec w)
{
    float z2 = w.z * w.z;
    return 0.5f * (std::sqrt(1.0f + alpha * alpha * (w.x * w.x + w.y * w.y) / (z2 > 1e-12f ? z2 : 1e-12f)) - 1.0f);
}

inline float ggx_density(float alpha, vec h)
{
    float a2 = alpha * alpha, d = h.z * h.z * (a2 - 1.0f) + 1.0f;
    return a2 / (pi * d * d);
}

// The probability with which sample() follows the coat.
inline float coat_probability(const surface &s, vec wo)
{
    float coat = luminance(fresnel(s.f0, wo.z)), base = luminance(s.diffuse);
    return coat + base > 0.0f ? clamp(coat / (coat + base), 0.25f, base > 0.0f ? 0.75f : 1.0f) : 1.0f;
}

// f(wo, wi) |cos wi|, and the density of sample() at wi.
inline vec evaluate(const surface &s, vec wo, vec wi, float *density)
{
    *density = 0.0f;
    if (wi.z <= 0.0f || wo.z <= 0.0f) return {0.0f, 0.0f, 0.0f};
    vec h = normalize(wo + wi), f = fresnel(s.f0, dot(wo, h));
    float d = ggx_density(s.alpha, h), lo = ggx_lambda(s.alpha, wo), li = ggx_lambda(s.alpha, wi);
    float coat = d / ((1.0f + lo + li) * 4.0f * wo.z), p = coat_probability(s, wo);
    *density = p * d / ((1.0f + lo) * 4.0f * wo.z) + (1.0f - p) * wi.z / pi;
    return coat * f + (wi.z / pi) * (s.diffuse * (vec{1.0f, 1.0f, 1.0f} - f));
}

inline vec sample_cosine(point2 u)
{
    float r = std::sqrt(u.x), a = 2.0f * pi * u.y;
    return {r * std::cos(a), r * std::sin(a), std::sqrt(1.0f - u.x)};
}

// A microfacet normal that wo sees: the projected disc of the stretched hemisphere.
inline vec sample_visible_normal(float alpha, vec wo, point2 u)
{
    vec n = normalize(vec{alpha * wo.x, alpha * wo.y, wo.z});
    float r = std::sqrt(u.x), a = 2.0f * pi * u.y, x = r * std::cos(a), y = r * std::sin(a);
    vec t = n.x * n.x + n.y * n.y > 1e-12f ? normalize(vec{-n.y, n.x, 0.0f}) : vec{1.0f, 0.0f, 0.0f};
    vec b = cross(n, t);
    float half = 0.5f * (1.0f + n.z); // the half of the disc that n foreshortens
    y = (1.0f - half) * std::sqrt(1.0f - x * x) + half * y;
    float z2 = 1.0f - x * x - y * y;
    vec h = x * t + y * b + std::sqrt(z2 > 0.0f ? z2 : 0.0f) * n;
    return normalize(vec{alpha * h.x, alpha * h.y, h.z > 1e-6f ? h.z : 1e-6f});
}

// A direction wi with the density that evaluate() answers; below the surface (wi.z <= 0) it carries nothing.
inline vec sample(const surface &s, vec wo, float lobe, point2 u)
{
    if (lobe >= coat_probability(s, wo)) return sample_cosine(u);
    vec h = sample_visible_normal(s.alpha, wo, u);
    return (2.0f * dot(wo, h)) * h - wo;
}

} // namespace knr

#endif
