// SPDX-License-Identifier: Apache-2.0
// Inside bridges/occt: the entities of a STEP model as text, some taken out with all that they alone used.
#ifndef BRIDGES_OCCT_STEP_TEXT_HPP
#define BRIDGES_OCCT_STEP_TEXT_HPP

#include <string>
#include <vector>

namespace kn_occt
{

class step_text
{
  public:
    // The DATA section of an ISO 10303-21 file; nothing is thrown away yet. OCCT writes colours in an order of
    // addresses, another one in each run: here they are in the order of what they belong to.
    explicit step_text(const std::string &file);
    // Takes entities out: lists lose them, what needs them goes, too, and what nobody else uses; those that stay are
    // left as they are, whether they are used or not.
    void remove(const std::vector<unsigned> &numbers, const std::vector<unsigned> &stay);
    // "#n=..;" line by line of what is left, less `hidden` ones.
    std::string lines(const std::vector<unsigned> &hidden) const;
    unsigned numbers() const // the largest
    {
        return entities.empty() ? 0 : static_cast<unsigned>(entities.size() - 1);
    }
    std::vector<unsigned> references(unsigned n) const;   // what entity n refers to, in its order
    const std::vector<unsigned> &users(unsigned n) const; // what refers to it, or did before `remove`
    unsigned first_with(const char *part) const;          // the first entity with this in its text; 0: none
    std::string name(unsigned n) const;                   // "EDGE_CURVE"; "": a complex entity, or none

  private:
    struct mention {
        unsigned number;
        size_t begin, end; // in the text: "#12"
        int depth;         // of parentheses
    };
    std::vector<std::string> entities; // by number, from '=' on; empty: there is none
    std::vector<std::vector<unsigned>> using_it;

    void note_users();
    void order_colors();
    void reach(unsigned n, unsigned first, std::vector<unsigned> &order, std::vector<bool> &seen) const;
    static std::vector<mention> mentions(const std::string &text);
    bool cut(std::string &text, unsigned number) const;
};

} // namespace kn_occt

#endif
