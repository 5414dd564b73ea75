// SPDX-License-Identifier: Apache-2.0
// kn_render: a path tracer on Embree. The object is traced; the ground is the backdrop times the share of light that
// the object leaves to it, so that it runs seamlessly into the background.
#include "bridges/embree/render.h"

#include <cfloat>
#include <cstdlib>

#include <embree3/rtcore.h>

#include "bridges/embree/material.h"
#include "bridges/embree/studio.h"
extern "C" {
#include "kernel/context.h"
#include "kernel/parallel.h"
}

namespace
{

using namespace knr;

constexpr float epsilon = 2e-5f; // ray offsets, in radii of the object
constexpr float far_away = 1e30f;
constexpr float indirect_limit = 2.5f; // luminance of one bounce's contribution: above it are fireflies
constexpr float sample_limit =
    3.0f; // of a whole sample: white, and small enough that edges of highlights stay smooth
constexpr float ground_limit = 0.6f; // and of the object's light on the ground

// One item as the tracer sees it. position has room for Embree's 16-byte loads behind the last vertex.
struct shape {
    const uint32_t *triangle;
    float *position, *normal; // normal may be NULL
    const float *color;       // of the vertices, may be NULL
    surface look;
    vec metal; // the part of look.f0 that vertex colours tint
};

struct camera {
    vec eye, right, up, forward; // right and up are scaled to the half width and half height at distance 1
};

// What a pixel is averaged from and into, pass by pass.
struct layer {
    vec lit, open;  // light on the ground with the object there, and without it: sums
    vec colour;     // of the object, developed
    float variance; // of the mean of its brightness
};

struct pixel {
    float samples, ground; // how many, and how many of them see the ground or the background
    vec object, normal;    // sums over the others: radiance and shading normal
    float depth;           // and distance
    layer smooth[2];
};

struct tracer {
    RTCScene scene;
    const shape *shapes;
    studio st;
    camera cam;
    float ground;
    int width, height, samples, bounces;
    float flatness;
    uint32_t seed, mask;
    pixel *film;
    int pass;
    uint8_t *rgb;
};

struct hit {
    float distance;   // far_away: nothing
    int item;         // -1: the ground
    vec origin;       // where rays leave, on the ray's side
    vec face, normal; // geometric and shading normal, on the ray's side
    surface look;
};

// ---- rays ----

vec load(const float *at, uint32_t index)
{
    const float *p = at + 3 * static_cast<size_t>(index);
    return {p[0], p[1], p[2]};
}

// Where a smooth surface through the vertices with their normals would be: rays that leave from there do not meet
// the facet's neighbours. Source: Hanika, Hacking the shadow terminator, Ray Tracing Gems II, 2021.
vec smooth_point(vec p, const vec corner[3], const vec normal[3], const float weight[3])
{
    vec out = p;
    for (int k = 0; k < 3; k++) {
        float below = dot(p - corner[k], normal[k]);
        if (below < 0.0f) out = out - (weight[k] * below) * normal[k];
    }
    return out;
}

surface tinted(const shape &s, const uint32_t *index, const float weight[3])
{
    vec c = {0.0f, 0.0f, 0.0f};
    for (int k = 0; k < 3; k++) c = c + weight[k] * load(s.color, index[k]);
    surface out = s.look;
    out.diffuse = c * out.diffuse;
    out.f0 = out.f0 + (c - vec{1.0f, 1.0f, 1.0f}) * s.metal;
    return out;
}

void fill_hit(const tracer &t, hit *h, const RTCHit &from, vec d)
{
    const shape &s = t.shapes[from.geomID];
    const uint32_t *index = s.triangle + 3 * static_cast<size_t>(from.primID);
    const float weight[3] = {1.0f - from.u - from.v, from.u, from.v};
    vec corner[3], normal[3], sum = {0.0f, 0.0f, 0.0f};
    for (int k = 0; k < 3; k++) corner[k] = load(s.position, index[k]);
    vec face = normalize(cross(corner[1] - corner[0], corner[2] - corner[0]));
    if (dot(face, d) > 0.0f) face = -face;
    vec p = weight[0] * corner[0] + weight[1] * corner[1] + weight[2] * corner[2];
    h->item = static_cast<int>(from.geomID);
    h->look = s.color ? tinted(s, index, weight) : s.look;
    h->face = h->normal = face;
    h->origin = p + epsilon * face;
    if (!s.normal) return;
    for (int k = 0; k < 3; k++) {
        normal[k] = load(s.normal, index[k]);
        if (dot(normal[k], face) < 0.0f) normal[k] = -normal[k];
        sum = sum + weight[k] * normal[k];
    }
    if (!(dot(sum, sum) > 1e-6f)) return; // normals that cancel, or are not numbers
    vec n = normalize(sum);
    float away = dot(n, d); // a shading normal that the viewer could not see is bent until he does
    if (away > -0.02f) n = normalize(n - (away + 0.02f) * d);
    h->normal = n;
    h->origin = smooth_point(p, corner, normal, weight) + epsilon * face;
}

hit intersect(const tracer &t, vec origin, vec d)
{
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    RTCRayHit r = {};
    r.ray.org_x = origin.x, r.ray.org_y = origin.y, r.ray.org_z = origin.z;
    r.ray.dir_x = d.x, r.ray.dir_y = d.y, r.ray.dir_z = d.z;
    r.ray.tnear = 0.0f, r.ray.tfar = far_away, r.ray.mask = ~0u;
    r.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(t.scene, &context, &r);
    hit h = {};
    h.distance = r.ray.tfar;
    if (r.hit.geomID != RTC_INVALID_GEOMETRY_ID) {
        fill_hit(t, &h, r.hit, d);
        return h;
    }
    h.distance = d.z < -1e-6f ? (t.ground - origin.z) / d.z : far_away;
    h.item = -1;
    if (!(h.distance > 0.0f)) h.distance = far_away;
    h.face = h.normal = {0.0f, 0.0f, 1.0f};
    h.origin = origin + h.distance * d;
    h.origin.z = t.ground + epsilon;
    return h;
}

bool visible(const tracer &t, vec origin, vec d, float distance)
{
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    RTCRay r = {};
    r.org_x = origin.x, r.org_y = origin.y, r.org_z = origin.z;
    r.dir_x = d.x, r.dir_y = d.y, r.dir_z = d.z;
    r.tfar = distance, r.mask = ~0u;
    rtcOccluded1(t.scene, &context, &r);
    return r.tfar > 0.0f;
}

// ---- light ----

// The ground as other surfaces see it: diffuse, one light sample, fading into the dome's horizon.
vec ground_radiance(const tracer &t, const hit &h, vec d, float select, point2 u)
{
    light_sample l = sample_light(t.st, choose_lights(t.st, h.origin, h.normal), h.origin, select, u);
    vec e = {0.0f, 0.0f, 0.0f};
    if (l.density > 0.0f && l.to.z > 0.0f && visible(t, h.origin, l.to, l.distance))
        e = (l.to.z / l.density) * l.radiance;
    float reach = std::sqrt(h.origin.x * h.origin.x + h.origin.y * h.origin.y);
    float open = smoothstep(0.3f, 1.5f, reach); // the dome is hidden under the object
    vec near = (0.5f / pi) * (e + (t.st.exposure * dome_irradiance * (0.3f + 0.7f * open)) * vec{1.0f, 1.0f, 1.0f});
    vec level = normalize(vec{d.x, d.y, 0.0f});
    return mix(near, dome(t.st, level), smoothstep(3.0f, 9.0f, reach));
}

vec direct(const tracer &t, const hit &h, const surface &look, const frame &at, vec wo, const choice &of,
           float select, point2 u)
{
    light_sample l = sample_light(t.st, of, h.origin, select, u);
    vec wi = at.to_local(l.to);
    if (!(l.density > 0.0f) || wi.z <= 0.0f) return {0.0f, 0.0f, 0.0f};
    float density;
    vec f = evaluate(look, wo, wi, &density);
    if (luminance(f) <= 0.0f || !visible(t, h.origin, l.to, l.distance)) return {0.0f, 0.0f, 0.0f};
    return (1.0f / (l.density + density)) * (f * l.radiance); // balance heuristic: (l.density / sum) / l.density
}

vec limit(vec c, float most)
{
    float y = luminance(c);
    return y > most ? (most / y) * c : c;
}

// The radiance that leaves the object at h towards -d. Points from `pair` on are this path's.
vec follow(const tracer &t, hit h, vec d, const sampler &points, uint32_t pair, int bounces)
{
    vec sum = {0.0f, 0.0f, 0.0f}, carried = {1.0f, 1.0f, 1.0f};
    for (int bounce = 0; bounce < bounces; bounce++, pair += 3) {
        const surface look = h.look;
        frame at(h.normal);
        vec wo = at.to_local(-d);
        point2 a = points.point(pair), b = points.point(pair + 1), c = points.point(pair + 2);
        bool narrow = look.narrower(bounce ? 0.2f : 0.05f); // what is seen in another thing may be noisier
        choice of = narrow ? choice{} : choose_lights(t.st, h.origin, h.normal);
        vec here = narrow ? vec{0.0f, 0.0f, 0.0f} : carried * direct(t, h, look, at, wo, of, a.x, b);
        sum = sum + (bounce ? limit(here, indirect_limit) : here);

        vec wi = sample(look, wo, a.y, c);
        float density;
        vec f = evaluate(look, wo, wi, &density);
        if (!(density > 0.0f)) break;
        carried = (1.0f / density) * (carried * f);
        float survive = clamp(luminance(carried), 0.0f, 0.95f);
        if (bounce >= 2) { // Russian roulette on a digit that nothing else uses
            if (sampler::unit(hash(hash(points.seed, points.index), pair)) >= survive) break;
            carried = (1.0f / survive) * carried;
        }
        d = at.to_world(wi);
        hit next = intersect(t, h.origin, d);
        vec seen = lights_along(t.st, narrow ? nullptr : &of, h.origin, d, next.distance, density);
        if (next.distance >= far_away) seen = seen + dome(t.st, d);
        if (next.distance < far_away && next.item < 0) seen = seen + ground_radiance(t, next, d, c.x, a);
        seen = carried * seen;
        sum = sum + limit(seen, bounce ? indirect_limit : 8.0f * indirect_limit);
        if (next.item < 0) break;
        h = next;
    }
    return luminance(sum) < far_away ? sum : vec{0.0f, 0.0f, 0.0f}; // not a number: one would spread
}

// One sample of the ground: a light, and a direction of the dome that the object may stand in.
void shade_ground(const tracer &t, layer *sums, const hit &h, const sampler &points)
{
    point2 a = points.point(1), b = points.point(2), c = points.point(3);
    light_sample l = sample_light(t.st, choose_lights(t.st, h.origin, h.normal), h.origin, a.x, b);
    if (l.density > 0.0f && l.to.z > 0.0f) {
        vec e = (l.to.z / (pi * l.density)) * l.radiance;
        sums->open = sums->open + e;
        if (visible(t, h.origin, l.to, l.distance)) sums->lit = sums->lit + e;
    }
    vec d = sample_cosine(c), sky = dome(t.st, d);
    hit next = intersect(t, h.origin, d);
    sums->open = sums->open + sky;
    sums->lit = sums->lit + (next.item < 0 ? sky : limit(follow(t, next, d, points, 4, 1), ground_limit));
}

// ---- the picture ----

// A tent of one pixel's radius, by inversion of its distribution function.
float tent(float u)
{
    return u < 0.5f ? std::sqrt(2.0f * u) - 1.0f : 1.0f - std::sqrt(2.0f - 2.0f * u);
}

void trace_sample(const tracer &t, pixel *px, int x, int y, const sampler &points)
{
    point2 u = points.point(0);
    float sx = 2.0f * (static_cast<float>(x) + 0.5f + tent(u.x)) / static_cast<float>(t.width) - 1.0f;
    float sy = 1.0f - 2.0f * (static_cast<float>(y) + 0.5f + tent(u.y)) / static_cast<float>(t.height);
    vec d = normalize(t.cam.forward + sx * t.cam.right + sy * t.cam.up);
    hit h = intersect(t, t.cam.eye, d);
    px->samples += 1.0f;
    if (h.item >= 0) {
        vec lit = limit(follow(t, h, d, points, 1, t.bounces), sample_limit);
        px->object = px->object + mix(lit, h.look.diffuse, t.flatness);
        px->normal = px->normal + h.normal, px->depth += h.distance;
        return;
    }
    px->ground += 1.0f;
    if (h.distance < far_away) shade_ground(t, px->smooth, h, points);
}

// A pixel filled by one smooth piece of the object: its normals agree.
bool is_smooth(const pixel &px)
{
    return px.ground == 0.0f && dot(px.normal, px.normal) > 0.995f * px.samples * px.samples;
}

// Plain ground is averaged with its neighbours later and needs few samples. The object gets all of them: to stop
// where they happen to agree would leave dark specks.
void trace_pixel(const tracer &t, int x, int y)
{
    size_t at = static_cast<size_t>(y) * static_cast<size_t>(t.width) + static_cast<size_t>(x);
    sampler points = {hash(t.seed, static_cast<uint32_t>(at)), 0, t.mask};
    pixel px = {};
    float sum = 0.0f, squares = 0.0f, n = 0.0f;
    for (int i = 0; i < t.samples; i++) {
        if ((i == 8 && px.ground == n) || (2 * i == t.samples && i >= 8 && is_smooth(px))) break;
        float before = luminance(px.object);
        points.index = static_cast<uint32_t>(i);
        trace_sample(t, &px, x, y, points);
        float more = luminance(px.object) - before;
        sum += more, squares += more * more, n += 1.0f;
    }
    float cover = n - px.ground, mean = sum / n;
    float variance = n > 1.0f ? (squares / n - mean * mean) / (n - 1.0f) : 1.0f;
    if (cover > 0.0f) px.smooth[0].colour = film((1.0f / cover) * px.object);
    px.smooth[0].variance = clamp(variance, 0.0f, 1.0f) / (1.0f + mean * mean); // the film flattens what is bright
    px.smooth[1] = px.smooth[0];
    t.film[at] = px;
}

enum { TILE = 16 };

kn_status trace_tile(kn_ctx *, void *user, size_t index)
{
    const tracer &t = *static_cast<const tracer *>(user);
    int across = (t.width + TILE - 1) / TILE, i = static_cast<int>(index);
    int x0 = i % across * TILE, y0 = i / across * TILE;
    for (int y = y0; y < y0 + TILE && y < t.height; y++)
        for (int x = x0; x < x0 + TILE && x < t.width; x++) trace_pixel(t, x, y);
    return KN_OK;
}

float share(float lit, float open)
{
    return open > 0.0f ? clamp(lit / open, 0.0f, 1.5f) : 1.0f;
}

const pixel *neighbour(const tracer &t, int x, int y)
{
    if (x < 0 || x >= t.width || y < 0 || y >= t.height) return nullptr;
    return t.film + static_cast<size_t>(y) * static_cast<size_t>(t.width) + static_cast<size_t>(x);
}

// Pass p averages over 5 x 5 pixels that lie 2^p apart, weighted by a B-spline and by likeness.
// Source: Dammertz et al., Edge-avoiding a-trous wavelet transform for fast global illumination filtering, 2010.
enum { GROUND_PASSES = 5, OBJECT_PASSES = 3 };
constexpr float spline[3] = {0.375f, 0.25f, 0.0625f};

// Ground is like ground with nearly the same share of light: shadows have soft edges.
void smooth_ground(const tracer &t, int x, int y, pixel *px)
{
    const int from = t.pass & 1, step = 1 << t.pass;
    const float range = t.pass ? 12.0f : 0.0f;
    float mine = share(luminance(px->smooth[from].lit), luminance(px->smooth[from].open));
    vec lit = {0.0f, 0.0f, 0.0f}, open = lit;
    for (int j = -2; j <= 2; j++)
        for (int i = -2; i <= 2; i++) {
            const pixel *other = neighbour(t, x + i * step, y + j * step);
            if (!other || other->ground <= 0.0f) continue;
            const layer &sums = other->smooth[from];
            float d = range * (share(luminance(sums.lit), luminance(sums.open)) - mine);
            float w = spline[std::abs(i)] * spline[std::abs(j)] / (1.0f + d * d);
            lit = lit + w * sums.lit, open = open + w * sums.open;
        }
    px->smooth[1 - from].lit = lit, px->smooth[1 - from].open = open;
}

// How much a pixel of the object is like this one by its place: its normal and its distance; 0: not at all.
float likeness(const pixel &px, const pixel *other, float reach)
{
    if (!other || !is_smooth(*other)) return 0.0f;
    vec turn = normalize(other->normal) - normalize(px.normal);
    float away = (other->depth / other->samples - px.depth / px.samples) / reach;
    float unlike = dot(turn, turn) * 200.0f + away * away;
    return 1.0f / (1.0f + unlike * unlike);
}

// The object is averaged with what is like it by place, and of a brightness that differs by noise only. The noise is
// that of the neighbourhood: a pixel's own estimate, from few samples, is often far too small.
void smooth_object(const tracer &t, int x, int y, pixel *px)
{
    const int from = t.pass & 1, step = 1 << t.pass;
    const float reach = 0.01f * static_cast<float>(step);
    float like[25], total = 0.0f, noise = 0.0f, variance = 0.0f;
    for (int k = 0; k < 25; k++) {
        const int i = k % 5 - 2, j = k / 5 - 2;
        const pixel *other = neighbour(t, x + i * step, y + j * step);
        like[k] = spline[std::abs(i)] * spline[std::abs(j)] * likeness(*px, other, reach);
        total += like[k];
        if (like[k] > 0.0f) noise += like[k] * other->smooth[from].variance;
    }
    noise = noise / total + 2e-5f;
    vec colour = {0.0f, 0.0f, 0.0f};
    total = 0.0f;
    for (int k = 0; k < 25; k++) {
        if (!(like[k] > 0.0f)) continue;
        const layer &theirs = neighbour(t, x + (k % 5 - 2) * step, y + (k / 5 - 2) * step)->smooth[from];
        vec differ = theirs.colour - px->smooth[from].colour;
        float unlike = dot(differ, differ) / (8.0f * noise), w = like[k] / (1.0f + unlike * unlike);
        colour = colour + w * theirs.colour;
        variance += w * w * theirs.variance, total += w;
    }
    px->smooth[1 - from].colour = (1.0f / total) * colour;
    px->smooth[1 - from].variance = variance / (total * total);
}

kn_status smooth_row(kn_ctx *, void *user, size_t row)
{
    const tracer &t = *static_cast<const tracer *>(user);
    for (int x = 0; x < t.width; x++) {
        pixel *px = t.film + row * static_cast<size_t>(t.width) + static_cast<size_t>(x);
        if (px->ground > 0.0f) smooth_ground(t, x, static_cast<int>(row), px);
        if (t.pass < OBJECT_PASSES && is_smooth(*px)) smooth_object(t, x, static_cast<int>(row), px);
    }
    return KN_OK;
}

uint8_t to_byte(float linear, float noise)
{
    return static_cast<uint8_t>(clamp(255.0f * encode_srgb(linear) + 0.5f + noise, 0.0f, 255.0f));
}

// A pixel of the object that outshines all its neighbours is an accident of sampling: it becomes as bright as they
// are.
vec without_speck(const tracer &t, int x, int y, const layer &own)
{
    float most = 0.0f;
    int n = 0;
    for (int j = -1; j <= 1; j++)
        for (int i = -1; i <= 1; i++) {
            const pixel *other = i || j ? neighbour(t, x + i, y + j) : nullptr;
            if (!other || other->ground == other->samples) continue;
            float bright = luminance(other->smooth[OBJECT_PASSES & 1].colour);
            most = bright > most ? bright : most, n++;
        }
    return n > 3 ? limit(own.colour, most) : own.colour;
}

// Half a step of noise hides the bands of the backdrop's slow gradient.
kn_status develop_row(kn_ctx *, void *user, size_t row)
{
    const tracer &t = *static_cast<const tracer *>(user);
    float y = 1.0f - (2.0f * static_cast<float>(row) + 1.0f) / static_cast<float>(t.height);
    for (int i = 0; i < t.width; i++) {
        size_t at = row * static_cast<size_t>(t.width) + static_cast<size_t>(i);
        const pixel &px = t.film[at];
        float x = (2.0f * static_cast<float>(i) + 1.0f) / static_cast<float>(t.width) - 1.0f;
        const layer &ground = px.smooth[GROUND_PASSES & 1], &object = px.smooth[OBJECT_PASSES & 1];
        float cover = 1.0f - px.ground / px.samples;
        vec light = {share(ground.lit.x, ground.open.x), share(ground.lit.y, ground.open.y),
                     share(ground.lit.z, ground.open.z)};
        vec seen = cover > 0.0f ? without_speck(t, i, static_cast<int>(row), object) : object.colour;
        vec c = cover * seen + (1.0f - cover) * (light * backdrop(x, y));
        uint32_t n = hash(static_cast<uint32_t>(at), 0x2c1b3c6du);
        float noise = sampler::unit(n) - 0.5f;
        t.rgb[3 * at] = to_byte(c.x, noise);
        t.rgb[3 * at + 1] = to_byte(c.y, noise);
        t.rgb[3 * at + 2] = to_byte(c.z, noise);
    }
    return KN_OK;
}

// ---- the scene ----

struct placement {
    double centre[3], scale;
    double turn[2]; // cosine and sine of the rotation about z that puts the camera at -y
    kn_up_axis up;
};

// Scene coordinates to z up, unscaled.
void upright(double out[3], const double *p, kn_up_axis up)
{
    out[0] = p[0], out[1] = up == KN_UP_Y ? -p[2] : p[1], out[2] = up == KN_UP_Y ? p[1] : p[2];
}

vec place(const placement &pl, const double *p)
{
    double q[3];
    upright(q, p, pl.up);
    for (int c = 0; c < 3; c++) q[c] = (q[c] - pl.centre[c]) * pl.scale;
    return {static_cast<float>(pl.turn[0] * q[0] + pl.turn[1] * q[1]),
            static_cast<float>(pl.turn[0] * q[1] - pl.turn[1] * q[0]), static_cast<float>(q[2])};
}

// Checks every vertex and index, and finds the box of what the triangles use.
kn_status measure(kn_ctx *ctx, placement *pl, const kn_scene *scene)
{
    double lo[3] = {DBL_MAX, DBL_MAX, DBL_MAX}, hi[3] = {-DBL_MAX, -DBL_MAX, -DBL_MAX}, q[3], size = 0.0;
    size_t triangles = 0;
    for (int i = 0; i < scene->nitems; i++) {
        const kn_mesh &m = scene->items[i].mesh;
        for (size_t k = 0; k < 3 * m.ntriangles; k++) {
            if (m.triangle[k] >= m.nvertices)
                return kn_fail(ctx, KN_EDOMAIN, "render: triangle %zu of item %d has vertex %u of %zu", k / 3, i,
                               m.triangle[k], m.nvertices);
            upright(q, m.position + 3 * static_cast<size_t>(m.triangle[k]), pl->up);
            for (int c = 0; c < 3; c++) {
                if (!std::isfinite(q[c]))
                    return kn_fail(ctx, KN_EDOMAIN, "render: vertex %u of item %d is not finite", m.triangle[k], i);
                lo[c] = q[c] < lo[c] ? q[c] : lo[c], hi[c] = q[c] > hi[c] ? q[c] : hi[c];
            }
        }
        triangles += m.ntriangles;
    }
    if (triangles == 0) return kn_fail(ctx, KN_EDOMAIN, "render: the scene has no triangles");
    for (int c = 0; c < 3; c++) {
        double half = 0.5 * hi[c] - 0.5 * lo[c];
        pl->centre[c] = lo[c] + half;
        size = std::hypot(size, half);
    }
    if (!(size > 0.0 && std::isfinite(1.0 / size)))
        return kn_fail(ctx, KN_EDOMAIN, "render: the scene's size is %g", size);
    pl->scale = 1.0 / size;
    return KN_OK;
}

float unit(double x)
{
    return x > 0.0 ? (x < 1.0 ? static_cast<float>(x) : 1.0f) : 0.0f;
}

void set_look(shape *s, const kn_material &m)
{
    vec base = {unit(m.base_color[0]), unit(m.base_color[1]), unit(m.base_color[2])};
    float metallic = unit(m.metallic), roughness = unit(m.roughness);
    float alpha = roughness * roughness;
    s->look = {(1.0f - metallic) * base, mix({0.04f, 0.04f, 0.04f}, base, metallic), alpha > 0.01f ? alpha : 0.01f};
    s->metal = metallic * base;
}

kn_status make_shape(kn_ctx *ctx, shape *s, const kn_scene_item *item, const placement &pl)
{
    const kn_mesh &m = item->mesh;
    const placement rotate = {{0.0, 0.0, 0.0}, 1.0, {pl.turn[0], pl.turn[1]}, pl.up};
    set_look(s, item->material), s->triangle = m.triangle, s->color = item->color;
    s->position = static_cast<float *>(kn_alloc_zero(ctx, 3 * m.nvertices + 4, sizeof(float)));
    if (m.normal) s->normal = static_cast<float *>(kn_alloc(ctx, 3 * m.nvertices, sizeof(float)));
    if (!s->position || (m.normal && !s->normal)) return KN_ENOMEM;
    for (size_t v = 0; v < m.nvertices; v++) {
        vec p = place(pl, m.position + 3 * v);
        s->position[3 * v] = p.x, s->position[3 * v + 1] = p.y, s->position[3 * v + 2] = p.z;
        if (!m.normal) continue;
        vec n = normalize(place(rotate, m.normal + 3 * v));
        s->normal[3 * v] = n.x, s->normal[3 * v + 1] = n.y, s->normal[3 * v + 2] = n.z;
    }
    return KN_OK;
}

kn_status embree_status(kn_ctx *ctx, RTCDevice device, const char *what)
{
    RTCError e = rtcGetDeviceError(device);
    if (e == RTC_ERROR_NONE) return KN_OK;
    return kn_fail(ctx, e == RTC_ERROR_OUT_OF_MEMORY ? KN_ENOMEM : KN_EDOMAIN, "render: Embree: %s: error %d", what,
                   static_cast<int>(e));
}

kn_status attach(kn_ctx *ctx, RTCDevice device, RTCScene scene, const shape *s, const kn_mesh *m, unsigned int id)
{
    RTCGeometry g = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    if (!g) return embree_status(ctx, device, "geometry");
    rtcSetSharedGeometryBuffer(g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, s->position, 0, 12, m->nvertices);
    rtcSetSharedGeometryBuffer(g, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, s->triangle, 0, 12, m->ntriangles);
    rtcCommitGeometry(g);
    rtcAttachGeometryByID(scene, g, id);
    rtcReleaseGeometry(g);
    return embree_status(ctx, device, "geometry");
}

// ---- the camera ----

// The least distance from which everything fits: in camera axes, the eye lies where the four planes through the
// picture's edges, pushed outwards until they touch the object, meet. Source: elementary; exact for points.
void frame_object(tracer *t, const kn_scene *scene, double elevation, double fov)
{
    const float margin = 0.86f; // share of the half picture that the object may fill
    float aspect = static_cast<float>(t->width) / static_cast<float>(t->height);
    float e = static_cast<float>(elevation) * (pi / 180.0f), ty = std::tan(static_cast<float>(fov) * (pi / 360.0f));
    float tx = ty * aspect, slope[2] = {margin * tx, margin * ty};
    vec forward = {0.0f, std::cos(e), -std::sin(e)}, right = {1.0f, 0.0f, 0.0f}, up = cross(right, forward);
    // Over the points p = (x, y, z) in these axes: the greatest x - slope z, and so on.
    float most[4] = {-far_away, -far_away, -far_away, -far_away};
    for (int i = 0; i < scene->nitems; i++) {
        const kn_mesh &m = scene->items[i].mesh;
        for (size_t k = 0; k < 3 * m.ntriangles; k++) {
            vec p = load(t->shapes[i].position, m.triangle[k]);
            float x = dot(p, right), y = dot(p, up), z = dot(p, forward);
            const float value[4] = {x - slope[0] * z, -x - slope[0] * z, y - slope[1] * z, -y - slope[1] * z};
            for (int q = 0; q < 4; q++) most[q] = value[q] > most[q] ? value[q] : most[q];
        }
    }
    // x - s z <= ex - s ez and -x - s z <= -ex - s ez meet in ez = -(a + b) / (2 s), ex = (a - b) / 2.
    float zx = -(most[0] + most[1]) / (2.0f * slope[0]), zy = -(most[2] + most[3]) / (2.0f * slope[1]);
    float ex = 0.5f * (most[0] - most[1]), ey = 0.5f * (most[2] - most[3]), ez = zx < zy ? zx : zy;
    t->cam = {ex * right + ey * up + ez * forward, tx * right, ty * up, forward};
}

kn_status check_options(kn_ctx *ctx, kn_render_options *o)
{
    if (o->width < 0 || o->height < 0 || o->samples < 0 || o->bounces < 0)
        return kn_fail(ctx, KN_EDOMAIN, "render: %d x %d pixels, %d samples, %d bounces", o->width, o->height,
                       o->samples, o->bounces);
    if (o->width > KN_RENDER_MAX_SIDE || o->height > KN_RENDER_MAX_SIDE || o->samples > KN_RENDER_MAX_SAMPLES ||
        o->bounces > KN_RENDER_MAX_BOUNCES)
        return kn_fail(ctx, KN_ELIMIT, "render: %d x %d pixels, %d samples, %d bounces", o->width, o->height,
                       o->samples, o->bounces);
    if (!(std::fabs(o->elevation) < 90.0) || !(o->fov >= 0.0 && o->fov < 120.0) || !std::isfinite(o->azimuth) ||
        !(std::fabs(o->exposure) < 32.0) || !(o->flatness >= 0.0 && o->flatness <= 1.0))
        return kn_fail(ctx, KN_EDOMAIN, "render: azimuth %g, elevation %g, fov %g, exposure %g, flatness %g",
                       o->azimuth, o->elevation, o->fov, o->exposure, o->flatness);
    if (o->up != KN_UP_Z && o->up != KN_UP_Y) return kn_fail(ctx, KN_EDOMAIN, "render: up axis %d", o->up);
    if (o->width == 0) o->width = 1600;
    if (o->height == 0) o->height = 1200;
    if (o->samples == 0) o->samples = 24;
    if (o->bounces == 0) o->bounces = 4;
    if (o->elevation == 0.0) o->elevation = 18.0;
    if (o->fov == 0.0) o->fov = 24.0;
    return KN_OK;
}

kn_status trace(kn_ctx *ctx, tracer *t)
{
    size_t w = static_cast<size_t>(t->width), h = static_cast<size_t>(t->height);
    size_t tiles = ((w + TILE - 1) / TILE) * ((h + TILE - 1) / TILE);
    t->film = static_cast<pixel *>(kn_alloc(ctx, w * h, sizeof *t->film));
    kn_status status = t->film ? kn_parallel(ctx, tiles, trace_tile, t, "render") : KN_ENOMEM;
    for (; t->pass < GROUND_PASSES && status == KN_OK; t->pass++)
        status = kn_parallel(ctx, h, smooth_row, t, nullptr);
    if (status == KN_OK) status = kn_parallel(ctx, h, develop_row, t, nullptr);
    kn_free(ctx, t->film);
    return status;
}

// One thread builds the hierarchy, so that it does not depend on how many there are.
kn_status with_embree(kn_ctx *ctx, tracer *t, const kn_scene *scene)
{
    RTCDevice device = rtcNewDevice("threads=1,set_affinity=0");
    if (!device) return embree_status(ctx, nullptr, "device");
    t->scene = rtcNewScene(device);
    kn_status status = embree_status(ctx, device, "scene");
    for (int i = 0; i < scene->nitems && status == KN_OK; i++)
        if (scene->items[i].mesh.ntriangles > 0)
            status = attach(ctx, device, t->scene, t->shapes + i, &scene->items[i].mesh,
                            static_cast<unsigned int>(i));
    if (status == KN_OK) status = kn_progress(ctx, "render", 0.0);
    if (status == KN_OK) rtcCommitScene(t->scene);
    if (status == KN_OK) status = embree_status(ctx, device, "hierarchy");
    if (status == KN_OK) status = trace(ctx, t);
    rtcReleaseScene(t->scene);
    rtcReleaseDevice(device);
    return status;
}

// The three-quarter view: the camera stands at -y, turned by this much towards +x.
constexpr double three_quarter = 25.0;

} // namespace

kn_render_options kn_render_defaults(void)
{
    return kn_render_options{};
}

kn_status kn_render(kn_ctx *ctx, uint8_t *rgb, const kn_scene *scene, const kn_render_options *options)
{
    kn_render_options o = options ? *options : kn_render_defaults();
    kn_status status = check_options(ctx, &o);
    placement pl = {};
    const double turn = (o.azimuth + three_quarter) * 3.14159265358979324 / 180.0;
    pl.turn[0] = std::cos(turn), pl.turn[1] = std::sin(turn), pl.up = o.up == KN_UP_Y ? KN_UP_Y : KN_UP_Z;
    if (status == KN_OK) status = measure(ctx, &pl, scene);
    if (status != KN_OK) return status;

    size_t n = static_cast<size_t>(scene->nitems);
    shape *shapes = static_cast<shape *>(kn_alloc_zero(ctx, n, sizeof *shapes));
    if (!shapes) status = KN_ENOMEM;
    for (size_t i = 0; i < n && status == KN_OK; i++) status = make_shape(ctx, shapes + i, scene->items + i, pl);
    if (status == KN_OK) {
        tracer t = {};
        t.shapes = shapes, t.rgb = rgb, t.seed = o.seed;
        t.width = o.width, t.height = o.height, t.samples = o.samples, t.bounces = o.bounces;
        while (t.mask + 1 < static_cast<uint32_t>(t.samples)) t.mask = 2 * t.mask + 1;
        t.flatness = static_cast<float>(o.flatness);
        t.st = make_studio(static_cast<float>(std::exp2(o.exposure)));
        frame_object(&t, scene, o.elevation, o.fov);
        t.ground = far_away;
        for (size_t i = 0; i < n; i++)
            for (size_t k = 0; k < 3 * scene->items[i].mesh.ntriangles; k++) {
                float z = shapes[i].position[3 * static_cast<size_t>(shapes[i].triangle[k]) + 2];
                t.ground = z < t.ground ? z : t.ground;
            }
        t.ground -= 1e-4f;
        status = with_embree(ctx, &t, scene);
    }
    for (size_t i = 0; i < n && shapes; i++) kn_free(ctx, shapes[i].position), kn_free(ctx, shapes[i].normal);
    kn_free(ctx, shapes);
    return status;
}
