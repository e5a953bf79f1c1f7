// The tables of a CIF file, as the library gemmi reads them.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

namespace isocast {

/// Some columns of a loop, or of items that are not in one: a single row.
struct CifTable {
    std::vector<std::vector<std::string>> rows; // without quotes; empty for '.', '?' and no column
    int line = 0;                               // where the loop starts
    bool is_there = false;
};

/// This header and its source are C++17: clang takes gemmi 0.5.7 for nothing newer.
class CifDocument {
public:
    /// throws  std::exception with "name:line:column: cause" if it is no CIF
    CifDocument(const char* bytes, std::size_t size, const std::string& name);
    ~CifDocument();

    /// The first data block with this tag is the one that the rest is about.
    bool choose_block(const std::string& tag);
    std::string block_name() const;
    /// Empty if there is none.
    std::string value(const std::string& tag) const;
    /// tags  after `prefix`; one that starts with '?' may be missing, all others must be there
    CifTable table(const std::string& prefix, const std::vector<std::string>& tags) const;

private:
    struct Parsed;
    std::unique_ptr<Parsed> parsed_;
};

} // namespace isocast
