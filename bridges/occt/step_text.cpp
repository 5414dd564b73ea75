// SPDX-License-Identifier: Apache-2.0
// The entities of a STEP model as text.
#include "bridges/occt/step_text.hpp"

#include <algorithm>
#include <cctype>
#include <cstring>
#include <locale>
#include <sstream>
#include <stdexcept>
#include <utility>

extern "C" {
#include "io/decimal.h"
}

namespace kn_occt
{
namespace
{

bool digit(char c)
{
    return c >= '0' && c <= '9';
}

// The number behind text[at] == '#', at most nine digits; *end: what follows it.
unsigned number_at(const std::string &text, size_t at, size_t *end)
{
    unsigned n = 0;
    size_t i = at + 1;
    for (; i < text.size() && digit(text[i]) && i - at < 10; i++) n = 10 * n + static_cast<unsigned>(text[i] - '0');
    *end = i;
    return i == at + 1 || (i < text.size() && digit(text[i])) ? 0 : n;
}

// The number that starts at text[at], as the shortest decimal that is the same double; *end: what follows it.
std::string shortest(const std::string &text, size_t at, size_t *end)
{
    size_t i = at;
    while (i < text.size() && (digit(text[i]) || std::strchr("+-.E", text[i]) != nullptr)) i++;
    *end = i;
    std::string number = text.substr(at, i - at);
    if (number.find('.') == std::string::npos) return number; // an integer
    std::istringstream stream(number);
    stream.imbue(std::locale::classic());
    double x = 0;
    char out[KN_DECIMAL_BYTES];
    if (!(stream >> x)) return number;
    return std::string(out, kn_decimal_step(out, x));
}

// Its reals shortened.
std::string shortened(const std::string &text)
{
    std::string out;
    bool quoted = false;
    for (size_t i = 0; i < text.size();) {
        char c = text[i], before = i > 0 ? text[i - 1] : ' ';
        if (c == '\'') quoted = !quoted;
        if (!quoted && (digit(c) || c == '-') && (before == '(' || before == ',')) {
            out += shortest(text, i, &i);
            continue;
        }
        out += c;
        i++;
    }
    return out;
}

} // namespace

step_text::step_text(const std::string &file)
{
    size_t at = file.find("\nDATA;");
    if (at == std::string::npos) throw std::runtime_error("OCCT wrote no DATA section");
    std::string entity;
    bool quoted = false, fresh = true; // fresh: the blanks that begin a line do not count
    for (at += 6; at < file.size(); at++) {
        char c = file[at];
        if (c == '\n' || c == '\r') {
            fresh = true;
            continue;
        }
        if (fresh && !quoted && c == ' ') continue;
        fresh = false;
        if (c == '\'') quoted = !quoted;
        if (c == ' ' && !quoted && (entity.empty() || !std::isalnum(static_cast<unsigned char>(entity.back()))))
            continue;
        entity += c;
        if (c != ';' || quoted) continue;
        if (entity == "ENDSEC;") {
            order_colors();
            note_users();
            return;
        }
        size_t end = 0;
        unsigned n = entity[0] == '#' ? number_at(entity, 0, &end) : 0;
        while (end < entity.size() && entity[end] == ' ') end++;
        if (n == 0 || end >= entity.size() || entity[end] != '=' || n > 1u << 30)
            throw std::runtime_error("OCCT wrote \"" + entity.substr(0, 40) + "\"");
        if (n >= entities.size()) entities.resize(n + 1);
        entities[n] = shortened(entity.substr(end));
        entity.clear();
    }
    throw std::runtime_error("OCCT wrote no end of its DATA section");
}

std::vector<step_text::mention> step_text::mentions(const std::string &text)
{
    std::vector<mention> found;
    bool quoted = false;
    int depth = 0;
    for (size_t i = 0; i < text.size(); i++) {
        char c = text[i];
        if (c == '\'') quoted = !quoted;
        if (quoted) continue;
        depth += (c == '(') - (c == ')');
        if (c != '#') continue;
        size_t end = i;
        unsigned n = number_at(text, i, &end);
        if (n > 0) found.push_back({n, i, end, depth});
    }
    return found;
}

std::vector<unsigned> step_text::references(unsigned n) const
{
    std::vector<unsigned> list;
    if (n < entities.size())
        for (const mention &m : mentions(entities[n])) list.push_back(m.number);
    return list;
}

// n and what it refers to, in that order, of the entities from `first` on that are not in it yet.
void step_text::reach(unsigned n, unsigned first, std::vector<unsigned> &order, std::vector<bool> &seen) const
{
    std::vector<unsigned> left = {n};
    while (!left.empty()) {
        unsigned at = left.back();
        left.pop_back();
        if (at < first || at >= entities.size() || seen[at] || entities[at].empty()) continue;
        seen[at] = true;
        order.push_back(at);
        std::vector<unsigned> refs = references(at);
        left.insert(left.end(), refs.rbegin(), refs.rend());
    }
}

// The colours of each part are a representation in the part's context, behind all geometry, with styles of its own. The
// representations come in the order of their contexts, each with its styles, and share their old numbers anew.
void step_text::order_colors()
{
    std::vector<std::pair<unsigned, unsigned>> roots; // context, number
    for (unsigned n = 0; n < entities.size(); n++)
        if (name(n) == "MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION") {
            std::vector<unsigned> refs = references(n);
            roots.push_back({refs.empty() ? 0 : refs.back(), n});
        }
    if (roots.size() < 2) return;
    const unsigned first = roots.front().second;
    std::sort(roots.begin(), roots.end());
    std::vector<unsigned> order;
    std::vector<bool> seen(entities.size());
    for (const auto &root : roots) reach(root.second, first, order, seen);
    std::vector<unsigned> numbers(order), becomes(entities.size());
    std::sort(numbers.begin(), numbers.end());
    for (unsigned n = 0; n < entities.size(); n++) becomes[n] = n;
    for (size_t i = 0; i < order.size(); i++) becomes[order[i]] = numbers[i];
    std::vector<std::string> moved(entities.size());
    for (unsigned n = 0; n < entities.size(); n++) {
        std::string text = std::move(entities[n]);
        std::vector<mention> all = mentions(text);
        for (size_t i = all.size(); i-- > 0;) // from the back: places before stay
            if (all[i].number >= first && all[i].number < entities.size())
                text.replace(all[i].begin, all[i].end - all[i].begin, "#" + std::to_string(becomes[all[i].number]));
        moved[becomes[n]] = std::move(text);
    }
    entities = std::move(moved);
}

void step_text::note_users()
{
    using_it.resize(entities.size());
    for (unsigned user = 0; user < entities.size(); user++)
        for (const mention &m : mentions(entities[user])) {
            if (m.number >= entities.size()) continue;
            std::vector<unsigned> &list = using_it[m.number];
            if (list.empty() || list.back() != user) list.push_back(user);
        }
}

const std::vector<unsigned> &step_text::users(unsigned n) const
{
    static const std::vector<unsigned> nobody;
    return n < using_it.size() ? using_it[n] : nobody;
}

unsigned step_text::first_with(const char *part) const
{
    for (unsigned n = 0; n < entities.size(); n++)
        if (entities[n].find(part) != std::string::npos) return n;
    return 0;
}

std::string step_text::name(unsigned n) const
{
    return n < entities.size() && !entities[n].empty() ? entities[n].substr(1, entities[n].find('(') - 1) : "";
}

// Out of lists alone; false where the entity needs it.
bool step_text::cut(std::string &text, unsigned number) const
{
    for (;;) {
        std::vector<mention> all = mentions(text);
        size_t i = 0;
        while (i < all.size() && all[i].number != number) i++;
        if (i == all.size()) return true;
        size_t begin = all[i].begin, end = all[i].end;
        bool before = text[begin - 1] == ',', after = end < text.size() && text[end] == ',';
        if (all[i].depth < (text[1] == '(' ? 3 : 2) || (!before && !after)) return false;
        if (after)
            end++;
        else
            begin--;
        text.erase(begin, end - begin);
    }
}

void step_text::remove(const std::vector<unsigned> &numbers, const std::vector<unsigned> &stay)
{
    std::vector<bool> stays(entities.size());
    for (unsigned n : stay) stays.at(n) = true;
    std::vector<size_t> uses(entities.size());
    for (const std::string &text : entities)
        for (const mention &m : mentions(text))
            if (m.number < entities.size()) uses[m.number]++;
    std::vector<unsigned> left = numbers;
    while (!left.empty()) {
        unsigned n = left.back();
        left.pop_back();
        if (n >= entities.size() || entities[n].empty()) continue;
        const std::string text = entities[n];
        entities[n].clear();
        for (unsigned user : using_it[n])
            if (!entities[user].empty() && !stays[user] && !cut(entities[user], n)) left.push_back(user);
        for (const mention &m : mentions(text))
            if (m.number < entities.size() && --uses[m.number] == 0 && !stays[m.number]) left.push_back(m.number);
    }
}

std::string step_text::lines(const std::vector<unsigned> &hidden) const
{
    std::vector<bool> shown(entities.size(), true);
    for (unsigned n : hidden)
        if (n < shown.size()) shown[n] = false;
    std::string text;
    for (size_t n = 0; n < entities.size(); n++)
        if (shown[n] && !entities[n].empty()) text += "#" + std::to_string(n) + entities[n] + "\n";
    return text;
}

} // namespace kn_occt
