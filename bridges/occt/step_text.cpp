// SPDX-License-Identifier: Apache-2.0
// The entities of a STEP model as text.
#include "bridges/occt/step_text.hpp"

#include <cctype>
#include <cstring>
#include <locale>
#include <sstream>
#include <stdexcept>

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
