// SPDX-License-Identifier: MPL-2.0
#include "quadrics/cif_tables.h"

#include <gemmi/cif.hpp>

namespace isocast {

struct CifDocument::Parsed {
    gemmi::cif::Document document;
    gemmi::cif::Block* block = nullptr;
};

CifDocument::CifDocument(const char* bytes, std::size_t size, const std::string& name)
    : parsed_(std::make_unique<Parsed>()) {
    parsed_->document = gemmi::cif::read_memory(bytes, size, name.c_str());
}

CifDocument::~CifDocument() = default;

bool CifDocument::choose_block(const std::string& tag) {
    for (gemmi::cif::Block& block : parsed_->document.blocks)
        if (block.has_tag(tag)) {
            parsed_->block = &block;
            return true;
        }
    return false;
}

std::string CifDocument::block_name() const {
    return parsed_->block->name;
}

std::string CifDocument::value(const std::string& tag) const {
    const std::string* value = parsed_->block->find_value(tag);
    return value ? gemmi::cif::as_string(*value) : std::string();
}

CifTable CifDocument::table(const std::string& prefix, const std::vector<std::string>& tags) const {
    gemmi::cif::Table theirs = parsed_->block->find(prefix, tags);
    CifTable table;
    if (!theirs.ok()) return table;
    table.is_there = true;
    if (theirs.loop_item) table.line = theirs.loop_item->line_number;
    table.rows.reserve(theirs.length());
    for (const gemmi::cif::Table::Row row : theirs) {
        std::vector<std::string>& cells = table.rows.emplace_back();
        cells.reserve(tags.size());
        for (std::size_t k = 0; k < tags.size(); ++k)
            cells.push_back(row.has2(k) ? row.str(static_cast<int>(k)) : std::string());
    }
    return table;
}

} // namespace isocast
