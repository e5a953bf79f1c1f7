// TOML to a SceneFile, by the table of keys.
// SPDX-License-Identifier: MPL-2.0
#include "apps/key_kinds.h"
#include "volume/errors.h"

#include <toml++/toml.h>

#include <algorithm>
#include <charconv>
#include <fstream>

namespace isocast {

namespace {

std::string joined(std::string_view path, std::string_view name) {
    return path.empty() ? std::string(name) : fmt::format("{}.{}", path, name);
}

const SceneTable* table_named(const std::vector<SceneTable>& tables, std::string_view name) {
    const auto found = std::ranges::find(tables, name, &SceneTable::name);
    return found == tables.end() ? nullptr : &*found;
}

/// What stands directly in the table `path`: its keys and tables.
std::string known_in(const std::vector<SceneTable>& tables, const std::string& path) {
    std::vector<std::string> names;
    if (const SceneTable* table = table_named(tables, path)) names.push_back(known_keys(*table));
    for (const SceneTable& table : tables) {
        const std::string prefix = path.empty() ? "" : path + ".";
        if (!table.name.starts_with(prefix)) continue;
        const std::string rest = table.name.substr(prefix.size());
        const std::string name = rest.substr(0, rest.find('.'));
        if (!name.empty() && std::ranges::find(names, name) == names.end()) names.push_back(name);
    }
    return fmt::format("{}", fmt::join(names, ", "));
}

/// throws  UsageError if a scene can have no such value
SceneValue value_of(const toml::node& node) {
    if (const auto* value = node.as_boolean()) return value->get();
    if (const auto* value = node.as_integer()) return value->get();
    if (const auto* value = node.as_floating_point()) return value->get();
    if (const auto* value = node.as_string()) return value->get();
    if (const auto* array = node.as_array()) {
        std::vector<double> numbers;
        std::vector<std::string> texts;
        for (const toml::node& element : *array)
            if (element.is_number())
                numbers.push_back(*element.value<double>());
            else if (const auto* text = element.as_string())
                texts.push_back(text->get());
        if (numbers.size() == array->size()) return numbers;
        if (texts.size() == array->size()) return texts;
    }
    throw UsageError("expected a number, true or false, a text, or a list of numbers or of texts");
}

class Reader {
public:
    Reader(SceneFile& scene, const std::filesystem::path& path)
        : scene_(scene), name_(path.string()), folder_(path.parent_path()) {}

    void read(const toml::table& table, const std::string& path, std::size_t element) {
        const SceneTable* known = table_named(tables_, path);
        const std::string full_path =
            known && known->is_array() ? fmt::format("{}.{}", path, element) : path;
        for (const auto& [key, node] : table) {
            const std::string name(key.str());
            const std::string child = joined(path, name);
            const SceneTable* child_table = table_named(tables_, child);
            if (const SceneKey* scene_key = known ? known->key(name) : nullptr)
                set(*scene_key, element, joined(full_path, name), node);
            else if (child_table && child_table->is_array())
                read_array(*child_table, child, node);
            else if (child_table || has_tables_below(child)) {
                if (const toml::table* below = node.as_table())
                    read(*below, child, 0);
                else
                    problem(node.source(), fmt::format("{} is a table: [{}]", child, child));
            } else {
                problem(key.source(),
                        fmt::format("unknown key '{}' (known: {})", joined(full_path, name),
                                    known_in(tables_, path)));
            }
        }
        // Who writes down an effect's table wants to see it.
        if (known && path.starts_with("effects.") && !table.contains("strength"))
            known->key("strength")->set(scene_, element, 1.0, folder_);
    }

    void problem(const toml::source_region& where, std::string_view what) {
        problems_.push_back(fmt::format("{}: {}", place(where), what));
    }
    /// throws  InputError if there was any
    void end() const {
        if (!problems_.empty()) throw InputError(fmt::format("{}", fmt::join(problems_, "\n")));
    }

private:
    std::string place(const toml::source_region& where) const {
        return fmt::format("{}:{}:{}", name_, where.begin.line, where.begin.column);
    }

    void set(const SceneKey& key, std::size_t element, const std::string& name,
             const toml::node& node) {
        scene_.places[name] = place(node.source());
        try {
            key.set(scene_, element, value_of(node), folder_);
        } catch (const std::runtime_error& error) {
            problem(node.source(), fmt::format("{}: {}", name, error.what()));
        }
    }

    void read_array(const SceneTable& table, const std::string& path, const toml::node& node) {
        const toml::array* array = node.as_array();
        if (!array || !std::ranges::all_of(*array, [](auto& e) { return e.is_table(); })) {
            problem(node.source(), fmt::format("{} is an array of tables: [[{}]]", path, path));
            return;
        }
        table.resize(scene_, 0);
        table.resize(scene_, array->size());
        for (std::size_t i = 0; i < array->size(); ++i) {
            scene_.places[fmt::format("{}.{}", path, i)] = place((*array)[i].source());
            read(*(*array)[i].as_table(), path, i);
        }
    }

    bool has_tables_below(const std::string& path) const {
        return std::ranges::any_of(
            tables_, [&](const SceneTable& table) { return table.name.starts_with(path + "."); });
    }

    SceneFile& scene_;
    std::string name_;
    std::filesystem::path folder_;
    std::vector<SceneTable> tables_ = scene_tables();
    std::vector<std::string> problems_;
};

struct FoundKey {
    SceneTable table;
    std::size_t element = 0;
    SceneKey key;
    std::string name; // in full
};

/// A key by its full name; without an index it is that of the first element.
/// throws  UsageError that lists the known ones
FoundKey find_key(const std::string& name) {
    const std::vector<SceneTable> tables = scene_tables();
    const auto dot = name.rfind('.');
    std::string path = dot == std::string::npos ? "" : name.substr(0, dot);
    const std::string last = dot == std::string::npos ? name : name.substr(dot + 1);
    std::size_t element = 0;
    const auto index_dot = path.rfind('.');
    const std::string_view index = std::string_view(path).substr(index_dot + 1);
    const char* end = index.data() + index.size();
    const bool has_index =
        index_dot != std::string::npos &&
        std::from_chars(index.data(), end, element) == std::from_chars_result{end, std::errc{}};
    if (has_index)
        path.resize(index_dot);
    else
        element = 0;
    const SceneTable* table = table_named(tables, path);
    const SceneKey* key = table ? table->key(last) : nullptr;
    if (!key || (has_index && !table->is_array())) {
        // What can stand where the name stops being known.
        while (!path.empty() && !table_named(tables, path) && known_in(tables, path).empty())
            path.resize(path.rfind('.') == std::string::npos ? 0 : path.rfind('.'));
        throw UsageError(fmt::format("unknown key '{}' (known{}: {})", name,
                                     path.empty() ? "" : " in " + path, known_in(tables, path)));
    }
    return {*table, element, *key,
            table->is_array() ? fmt::format("{}.{}.{}", path, element, last) : name};
}

/// A value as on a command line: TOML's, or a bare word.
SceneValue value_from(const std::string& text) {
    const auto is_one_line = [&] { return text.find_first_of("\n\r") == std::string::npos; };
    try {
        if (is_one_line()) {
            const toml::table parsed = toml::parse("value = " + text);
            return value_of(*parsed.get("value"));
        }
    } catch (const toml::parse_error&) {
    }
    return text;
}

} // namespace

SceneFile read_scene_file(const std::filesystem::path& path) {
    SceneFile scene{.path = path};
    Reader reader(scene, path);
    std::ifstream file(path, std::ios::binary);
    if (!file) throw InputError(fmt::format("{}: no such file", path.string()));
    const std::string text(std::istreambuf_iterator<char>(file), {});
    try {
        reader.read(toml::parse(text), "", 0);
    } catch (const toml::parse_error& error) {
        reader.problem(error.source(), error.description());
    }
    reader.end();
    return scene;
}

void set_key(SceneFile& scene, std::string_view assignment) {
    const auto equals = assignment.find('=');
    if (equals == std::string_view::npos)
        throw UsageError(fmt::format("'{}' is not KEY=VALUE", assignment));
    const FoundKey found = find_key(std::string(assignment.substr(0, equals)));
    if (found.table.is_array()) {
        const std::size_t count = found.table.count(scene);
        if (found.element > count)
            throw UsageError(
                fmt::format("{}: there are {} of [[{}]]", found.name, count, found.table.name));
        if (found.element == count) found.table.resize(scene, count + 1);
    }
    const std::string text(assignment.substr(equals + 1));
    const std::string in_front = found.name + ": ";
    try {
        try {
            found.key.set(scene, found.element, value_from(text), {});
        } catch (const keys::WrongType&) {
            found.key.set(scene, found.element, text, {}); // a text that looks like a number
        }
    } catch (const UsageError& error) {
        throw UsageError(in_front + error.what());
    } catch (const InputError& error) {
        throw InputError(in_front + error.what());
    }
    scene.places[found.name] = "command line";
}

void set_number(SceneFile& scene, const std::string& key, double value) {
    const FoundKey found = find_key(key);
    if (!found.key.is_number) throw UsageError(fmt::format("{} is no number", found.name));
    if (found.table.is_array() && found.element >= found.table.count(scene))
        throw UsageError(fmt::format("{}: there are {} of [[{}]]", found.name,
                                     found.table.count(scene), found.table.name));
    try {
        found.key.set(scene, found.element, value, {});
    } catch (const UsageError& error) {
        throw UsageError(fmt::format("{}: {}", found.name, error.what()));
    }
}

} // namespace isocast
