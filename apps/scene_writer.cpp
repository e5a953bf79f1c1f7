// A SceneFile to TOML, by the table of keys.
// SPDX-License-Identifier: MPL-2.0
#include "apps/scene_keys.h"
#include "volume/atomic_file.h"
#include "volume/errors.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <toml++/toml.h>

namespace isocast {

namespace {

std::string digits(double number) {
    const std::string text = fmt::format("{}", number);
    return text == "-0" ? "-0.0" : text; // as an integer it would lose its sign
}

/// toml++ would write a byte that is not UTF-8 as another letter.
std::string quoted(const std::string& text) {
    std::string out = "\"";
    for (const char c : text)
        if (c == '"' || c == '\\')
            out += {'\\', c};
        else if (const auto code = static_cast<unsigned char>(c); code < 0x20 || code == 0x7f)
            out += fmt::format("\\u{:04x}", code);
        else
            out += c;
    return out + '"';
}

template<class Element, class Write>
std::string list(const std::vector<Element>& elements, Write write) {
    std::vector<std::string> all;
    for (const Element& element : elements) all.push_back(write(element));
    return fmt::format("[{}]", fmt::join(all, ", "));
}

/// The keys of an element that differ from a new one's, a line for each.
std::string lines_of(const SceneTable& table, const SceneFile& scene, const SceneFile& fresh,
                     std::size_t i, const std::filesystem::path& folder) {
    std::string lines, strength;
    for (const SceneKey& key : table.keys) {
        std::optional<SceneValue> value;
        try {
            value = key.get(scene, i, folder);
        } catch (const InputError& error) {
            throw InputError(fmt::format("{}.{}: {}", table.name, key.name, error.what()));
        }
        if (!value) continue;
        const std::string line = fmt::format("{} = {}\n", key.name, written(*value));
        if (value != key.get(fresh, i, folder))
            lines += line;
        else if (key.name == "strength" && table.name.starts_with("effects."))
            strength = line; // which is 0; a table that does not say has 1
    }
    return lines.empty() ? "" : strength + lines;
}

} // namespace

std::string written(const SceneValue& value) {
    struct Write {
        std::string operator()(bool truth) const { return truth ? "true" : "false"; }
        std::string operator()(std::int64_t integer) const { return std::to_string(integer); }
        std::string operator()(double number) const { return digits(number); }
        std::string operator()(const std::string& text) const { return quoted(text); }
        std::string operator()(const std::vector<double>& numbers) const {
            return list(numbers, digits);
        }
        std::string operator()(const std::vector<std::string>& texts) const {
            return list(texts, quoted);
        }
    };
    return std::visit(Write{}, value);
}

std::string scene_text(const SceneFile& scene, const std::filesystem::path& folder) {
    std::string empty_arrays, text;
    for (const SceneTable& table : scene_tables()) {
        SceneFile fresh;
        const std::size_t fresh_count = table.is_array() ? table.count(fresh) : 1;
        const std::size_t count = table.is_array() ? table.count(scene) : 1;
        if (table.is_array()) {
            table.resize(fresh, 0);
            table.resize(fresh, count);
        }
        bool is_fresh = count == fresh_count;
        std::string elements;
        for (std::size_t i = 0; i < count; ++i) {
            const std::string lines = lines_of(table, scene, fresh, i, folder);
            is_fresh = is_fresh && lines.empty();
            elements += fmt::format("{}\n{}\n", header_of(table), lines);
        }
        if (is_fresh) continue;
        text += elements;
        if (count == 0) empty_arrays += table.name + " = []\n"; // before any table
    }
    text = empty_arrays + text;
    try {
        (void)toml::parse(text); // which refuses text that is not UTF-8
    } catch (const toml::parse_error& error) {
        throw InputError(fmt::format("this cannot be said in TOML: {}", error.description()));
    }
    return text;
}

void write_scene_file(const SceneFile& scene, const std::filesystem::path& path) {
    write_text_file(scene_text(scene, path.parent_path()), path);
}

} // namespace isocast
