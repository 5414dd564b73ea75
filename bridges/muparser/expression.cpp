// SPDX-License-Identifier: Apache-2.0
// kn_expression: muParser's parsers are not safe for threads, so there is one for each thread that may ask.
#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <new>
#include <string>
#include <thread>
#include <vector>

#include <muParser.h>

#include "bridges/muparser/expression.h"
extern "C" {
#include "kernel/context.h"
}

namespace
{

enum { U, V, X, Y, Z, NX, NY, NZ, MEAN, GAUSS, FACE, VARIABLES };

struct variable {
    const char *name;
    unsigned needs;
};
const variable variables[VARIABLES] = {
    {"u", 0},
    {"v", 0},
    {"x", KN_NEEDS_POINT},
    {"y", KN_NEEDS_POINT},
    {"z", KN_NEEDS_POINT},
    {"nx", KN_NEEDS_NORMAL},
    {"ny", KN_NEEDS_NORMAL},
    {"nz", KN_NEEDS_NORMAL},
    {"mean", KN_NEEDS_CURVATURE},
    {"gauss", KN_NEEDS_CURVATURE},
    {"face", 0},
};

double clamp(double x, double a, double b)
{
    return x < a ? a : x > b ? b : x;
}

double mix(double a, double b, double t)
{
    return a + t * (b - a);
}

double smooth(double a, double b, double x)
{
    double t = a == b ? (x < a ? 0.0 : 1.0) : clamp((x - a) / (b - a), 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}

double mod(double x, double y)
{
    return x - y * std::floor(x / y);
}

double floor_of(double x)
{
    return std::floor(x);
}

double noise(void *seed, double x, double y, double z)
{
    const double point[3] = {x, y, z};
    return kn_noise(point, *static_cast<const uint64_t *>(seed));
}

// One parser with its variables.
struct slot {
    std::atomic_flag busy = ATOMIC_FLAG_INIT;
    mu::Parser parser;
    double value[VARIABLES] = {};
};

void prepare(slot *s, const char *text, uint64_t *seed)
{
    for (int i = 0; i < VARIABLES; i++) s->parser.DefineVar(variables[i].name, &s->value[i]);
    s->parser.DefineConst("pi", 3.14159265358979323846);
    s->parser.DefineFun("clamp", clamp);
    s->parser.DefineFun("mix", mix);
    s->parser.DefineFun("smooth", smooth);
    s->parser.DefineFun("mod", mod);
    s->parser.DefineFun("floor", floor_of);
    s->parser.DefineFunUserData("noise", noise, seed);
    s->parser.SetExpr(text);
}

// Comparisons have '=' too: <= >= == !=. Alone it is an assignment. -1: none.
int assignment_in(const char *text)
{
    for (size_t i = 0; text[i]; i++) {
        if (text[i] != '=') continue;
        if (text[i + 1] == '=')
            i++;
        else if (i == 0 || !strchr("<>!", text[i - 1]))
            return static_cast<int>(i);
    }
    return -1;
}

// at: counted from 0, as muParser does, which also says it in words and may mean the blank that it appends.
kn_status fail_at(kn_ctx *ctx, const char *text, const std::string &message, int at)
{
    std::string line;
    int last = static_cast<int>(strnlen(text, 1 << 20));
    for (char c : message) line += c == '\n' || c == '\r' ? ' ' : c;
    for (const char *words : {" at expression position ", " at position "}) {
        size_t place = line.find(words);
        if (place != std::string::npos)
            line.erase(place, line.find_first_not_of("0123456789", place + strlen(words)) - place);
    }
    while (!line.empty() && (line.back() == '.' || line.back() == ' ')) line.pop_back();
    return kn_fail(ctx, KN_EPARSE, "expression '%.200s': %.200s, at %d", text, line.c_str(),
                   1 + (at < 0      ? 0
                        : at > last ? last
                                    : at));
}

} // namespace

struct kn_expression {
    uint64_t seed;
    unsigned needs;
    std::vector<std::unique_ptr<slot>> slots;
};

namespace
{

// What the expression asks for. Evaluating it once also shows whether it has one value.
kn_status examine(kn_ctx *ctx, kn_expression *e, const char *text)
{
    slot *s = e->slots[0].get();
    int values = 0;
    for (double &x : s->value) x = 0.5;
    s->parser.Eval(values);
    if (values != 1) return fail_at(ctx, text, "one value is expected, not several", 0);
    for (const auto &used : s->parser.GetUsedVar())
        for (const variable &v : variables)
            if (used.first == v.name) e->needs |= v.needs;
    return KN_OK;
}

void set_place(double *value, const kn_place *place)
{
    value[U] = place->uv[0];
    value[V] = place->uv[1];
    for (int c = 0; c < 3; c++) {
        value[X + c] = place->point[c];
        value[NX + c] = place->normal[c];
    }
    value[MEAN] = place->curvature[0];
    value[GAUSS] = place->curvature[1];
    value[FACE] = place->surface;
}

// Threads begin their search for a free slot at places of their own.
double value_of(const void *user, const kn_place *place)
{
    const kn_expression *e = static_cast<const kn_expression *>(user);
    size_t n = e->slots.size(), at = std::hash<std::thread::id>()(std::this_thread::get_id()) % n;
    for (size_t tries = 1; e->slots[at]->busy.test_and_set(std::memory_order_acquire); tries++) {
        at = (at + 1) % n;
        if (tries % n == 0) std::this_thread::yield();
    }
    slot *s = e->slots[at].get();
    double out = std::numeric_limits<double>::quiet_NaN();
    set_place(s->value, place);
    try {
        out = s->parser.Eval();
    } catch (...) { // a division by zero that the parser sees: undefined
    }
    s->busy.clear(std::memory_order_release);
    return out;
}

} // namespace

kn_status kn_expression_create(kn_ctx *ctx, kn_expression **out, const char *text, uint64_t seed)
{
    int at = assignment_in(text);
    if (at >= 0) return fail_at(ctx, text, "'=' assigns; '==' compares", at);
    try {
        std::unique_ptr<kn_expression> e(new kn_expression{seed, 0, {}});
        for (int i = 0; i < kn_ctx_threads(ctx); i++) {
            e->slots.emplace_back(new slot);
            prepare(e->slots.back().get(), text, &e->seed);
            e->slots.back()->parser.Eval(); // compiles it
        }
        kn_status status = examine(ctx, e.get(), text);
        if (status == KN_OK) *out = e.release();
        return status;
    } catch (const mu::Parser::exception_type &error) {
        return fail_at(ctx, text, error.GetMsg(), error.GetPos());
    } catch (const std::bad_alloc &) {
        return kn_fail(ctx, KN_ENOMEM, "expression: no memory");
    } catch (const std::exception &error) {
        return fail_at(ctx, text, error.what(), 0);
    }
}

void kn_expression_destroy(kn_ctx *, kn_expression *expression)
{
    delete expression;
}

kn_field kn_expression_field(const kn_expression *expression)
{
    return kn_field{value_of, expression, expression->needs};
}
