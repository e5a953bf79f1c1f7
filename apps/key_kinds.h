// The kinds of keys: from a member of SceneFile to the key that sets it.
// SPDX-License-Identifier: MPL-2.0
//
// A place gives a member, of element i of an array: (SceneFile&, std::size_t i) -> Member&.
#pragma once

#include "apps/inputs.h"
#include "apps/scene_keys.h"
#include "volume/errors.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <limits>
#include <string_view>
#include <utility>

namespace isocast::keys {

/// Places of the members of what `parent` is the place of: within(parent)(&Parent::member).
template<class Parent>
constexpr auto within(Parent parent) {
    return [parent]<class Member, class Class>(Member Class::*member) {
        return [ parent, member ](SceneFile & file, std::size_t i) -> auto& {
            return parent(file, i).*member;
        };
    };
}

/// A value of another type than a key has.
struct WrongType : UsageError {
    using UsageError::UsageError;
};

// From values to types. Each throws WrongType that says what was expected.
double number_of(const SceneValue& value);
int integer_of(const SceneValue& value);
bool truth_of(const SceneValue& value);
std::string text_of(const SceneValue& value);
std::vector<std::string> texts_of(const SceneValue& value);
Vec3d vector_of(const SceneValue& value);
/// Three numbers >= 0, linear RGB; or "#rrggbb", sRGB.
Vec3d colour_of(const SceneValue& value);

/// As TOML writes it.
std::string written(double value);
std::string written(const Vec3d& value);
inline std::string written(int value) {
    return std::to_string(value);
}
inline std::string written(bool value) {
    return value ? "true" : "false";
}
inline std::string written(const std::string& value) {
    return value.empty() ? "" : fmt::format("\"{}\"", value);
}
template<class Value>
std::string written(const std::optional<Value>& value) {
    return value ? written(*value) : "";
}

/// The value that a new scene has. Arrays have one element there.
template<class Place>
std::string initial(Place place) {
    SceneFile scene;
    scene.objects.resize(1);
    scene.camera_keys.resize(1);
    scene.animations.resize(1);
    scene.cut.planes.resize(1);
    return written(place(scene, std::size_t{0}));
}

template<class Place, class Parse>
SceneKey key(std::string name, std::string type, std::string help, Place place, Parse parse,
             bool is_number = false) {
    return {std::move(name),
            std::move(type),
            initial(place),
            std::move(help),
            is_number,
            [place, parse](SceneFile& scene, std::size_t i, const SceneValue& value,
                           const std::filesystem::path&) { place(scene, i) = parse(value); }};
}

/// Numbers between lo and hi.
struct Range {
    double lo = -std::numeric_limits<double>::infinity();
    double hi = std::numeric_limits<double>::infinity();
    bool is_open = false;       // without lo
    bool is_open_above = false; // without hi

    std::string text() const;
    /// throws  UsageError
    double checked(double value) const;
};
inline constexpr Range share{0, 1};
inline constexpr Range not_negative{.lo = 0};
inline constexpr Range positive{.lo = 0, .is_open = true};

template<class Place>
SceneKey number(std::string name, Place place, Range range, std::string help) {
    return key(
        std::move(name), "number" + range.text(), std::move(help), place,
        [range](const SceneValue& value) { return range.checked(number_of(value)); }, true);
}

template<class Place>
SceneKey integer(std::string name, Place place, Range range, std::string help) {
    return key(std::move(name), "integer" + range.text(), std::move(help), place,
               [range](const SceneValue& value) {
                   return static_cast<int>(range.checked(integer_of(value)));
               });
}

template<class Place>
SceneKey truth(std::string name, Place place, std::string help) {
    return key(std::move(name), "true | false", std::move(help), place, truth_of);
}

template<class Place>
SceneKey vector(std::string name, Place place, std::string help) {
    return key(std::move(name), "[x, y, z]", std::move(help), place, vector_of);
}

template<class Place>
SceneKey direction(std::string name, Place place, std::string help) {
    return key(std::move(name), "[x, y, z]", std::move(help), place, [](const SceneValue& value) {
        const Vec3d direction = vector_of(value);
        if (!(direction.norm() > 0)) throw UsageError("a direction must not be zero");
        return direction;
    });
}

template<class Place>
SceneKey colour(std::string name, Place place, std::string help) {
    return key(std::move(name), "colour", std::move(help), place, colour_of);
}

template<class Place>
SceneKey text(std::string name, Place place, std::string help) {
    return key(std::move(name), "text", std::move(help), place, text_of);
}

/// Names of values.
template<class Value>
using Names = std::vector<std::pair<std::string_view, Value>>;

/// The names that a function understands.
template<class FromName>
auto names_by(FromName from_name, std::initializer_list<std::string_view> names) {
    Names<decltype(from_name(""))> out;
    for (const std::string_view name : names) out.emplace_back(name, from_name(name));
    return out;
}

/// throws  UsageError that lists the names
template<class Value>
Value named(const Names<Value>& names, const SceneValue& value) {
    const auto* integer = std::get_if<std::int64_t>(&value); // a name like 8 needs no quotes
    const std::string name = integer ? std::to_string(*integer) : text_of(value);
    std::vector<std::string_view> known;
    for (const auto& [word, meaning] : names) {
        if (word == name) return meaning;
        known.push_back(word);
    }
    throw UsageError(fmt::format("'{}' is not one of {}", name, fmt::join(known, ", ")));
}

template<class Place, class Value>
SceneKey choice(std::string name, Place place, Names<Value> names, std::string help) {
    std::vector<std::string> quoted;
    for (const auto& [word, meaning] : names) quoted.push_back(fmt::format("\"{}\"", word));
    // What the member holds in a new scene, if anything.
    SceneFile scene;
    scene.objects.resize(1);
    const auto now = std::optional<Value>(place(scene, std::size_t{0}));
    std::string initial_name;
    for (const auto& [word, meaning] : names)
        if (now == meaning) initial_name = fmt::format("\"{}\"", word);
    return {std::move(name),
            fmt::format("{}", fmt::join(quoted, " | ")),
            std::move(initial_name),
            std::move(help),
            false,
            [place, names = std::move(names)](
                SceneFile& target, std::size_t i, const SceneValue& value,
                const std::filesystem::path&) { place(target, i) = named(names, value); }};
}

/// A key whose values need more than their member: files, or two members.
inline SceneKey special(
    std::string name, std::string type, std::string initial, std::string help,
    std::function<void(SceneFile&, std::size_t, const SceneValue&, const std::filesystem::path&)>
        set) {
    return {std::move(name), std::move(type), std::move(initial),
            std::move(help), false,           std::move(set)};
}

/// A path is relative to the folder, unless it is a built-in name.
std::string resolved(const std::string& name, const std::filesystem::path& folder);

template<class Place>
SceneKey picture(std::string name, Place place, std::string help) {
    return special(std::move(name), "file (.png, .exr)", "", std::move(help),
                   [place](SceneFile& file, std::size_t i, const SceneValue& value,
                           const std::filesystem::path& folder) {
                       place(file, i) = read_picture(resolved(text_of(value), folder));
                   });
}

} // namespace isocast::keys
