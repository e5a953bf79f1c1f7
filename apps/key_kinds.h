// The kinds of keys: from a member of SceneFile to the key that sets and gets it.
// SPDX-License-Identifier: MPL-2.0
//
// A place gives a member, of element i of an array: (SceneFile&, std::size_t i) -> Member&.
#pragma once

#include "apps/inputs.h"
#include "apps/scene_keys.h"
#include "volume/errors.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
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

// From members to values; nothing where they are empty.
using Value = std::optional<SceneValue>;
inline Value value_of(double number) {
    return number;
}
inline Value value_of(int integer) {
    return std::int64_t{integer};
}
inline Value value_of(bool truth) {
    return truth;
}
Value value_of(const std::string& text);
Value value_of(const std::vector<std::string>& texts);
Value value_of(const Vec3d& vector);
Value value_of(const std::array<double, 2>& interval);
template<class Member>
Value value_of(const std::optional<Member>& member) {
    return member ? value_of(*member) : std::nullopt;
}

/// The member of a place, to be read.
template<class Place>
const auto& member_at(Place place, const SceneFile& scene, std::size_t i) {
    return place(const_cast<SceneFile&>(scene), i); // places serve set and get; this is for get
}

/// With one element in each array.
SceneFile new_scene();

/// What makes a member what it is in a new scene.
template<class Place>
auto reset_of(Place place) {
    return [place](SceneFile& scene, std::size_t i) {
        SceneFile fresh = new_scene();
        place(scene, i) = place(fresh, 0);
    };
}

/// A key whose values need more than their member: files, or two members. What it gets from a new
/// scene is its initial value.
SceneKey special(std::string name, std::string type, std::string help, decltype(SceneKey::set) set,
                 decltype(SceneKey::get) get, bool is_number = false);

template<class Place, class Parse>
SceneKey key(std::string name, std::string type, std::string help, Place place, Parse parse,
             bool is_number = false) {
    SceneKey out = special(
        std::move(name), std::move(type), std::move(help),
        [place, parse](SceneFile& scene, std::size_t i, const SceneValue& value,
                       const std::filesystem::path&) { place(scene, i) = parse(value); },
        [place](const SceneFile& scene, std::size_t i, const std::filesystem::path&) {
            return value_of(member_at(place, scene, i));
        },
        is_number);
    out.reset = reset_of(place);
    return out;
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
template<class Meaning>
using Names = std::vector<std::pair<std::string_view, Meaning>>;

/// The names that a function understands.
template<class FromName>
auto names_by(FromName from_name, std::initializer_list<std::string_view> names) {
    Names<decltype(from_name(""))> out;
    for (const std::string_view name : names) out.emplace_back(name, from_name(name));
    return out;
}

/// throws  UsageError that lists the names
template<class Meaning>
Meaning named(const Names<Meaning>& names, const SceneValue& value) {
    const auto* integer = std::get_if<std::int64_t>(&value); // a name like 8 needs no quotes
    const std::string name = integer ? std::to_string(*integer) : text_of(value);
    std::vector<std::string_view> known;
    for (const auto& [word, meaning] : names) {
        if (word == name) return meaning;
        known.push_back(word);
    }
    throw UsageError(fmt::format("'{}' is not one of {}", name, fmt::join(known, ", ")));
}

template<class Place, class Meaning>
SceneKey choice(std::string name, Place place, Names<Meaning> names, std::string help) {
    std::vector<std::string> quoted;
    for (const auto& [word, meaning] : names) quoted.push_back(fmt::format("\"{}\"", word));
    SceneKey out = special(
        std::move(name), fmt::format("{}", fmt::join(quoted, " | ")), std::move(help),
        [place, names](SceneFile& scene, std::size_t i, const SceneValue& value,
                       const std::filesystem::path&) { place(scene, i) = named(names, value); },
        [place, names](const SceneFile& scene, std::size_t i,
                       const std::filesystem::path&) -> Value {
            const std::optional<Meaning> now = member_at(place, scene, i);
            for (const auto& [word, meaning] : names)
                if (now && *now == meaning) return std::string(word);
            return std::nullopt;
        });
    out.reset = reset_of(place);
    return out;
}

/// A path is relative to the folder, unless it is a built-in name.
std::string resolved(const std::string& name, const std::filesystem::path& folder);

/// The other way: relative to the folder if it lies below.
Value path_value(const std::string& path, const std::filesystem::path& folder);
/// That of what was read from `path`.
/// throws  InputError if something is there and no path
Value path_value_of_read(bool is_there, const std::string& path,
                         const std::filesystem::path& folder);

/// path_place  of the path that the picture was read from
template<class Place, class PathPlace>
SceneKey picture(std::string name, Place place, PathPlace path_place, std::string help) {
    return special(
        std::move(name), "file (.png, .exr)", std::move(help),
        [place, path_place](SceneFile& scene, std::size_t i, const SceneValue& value,
                            const std::filesystem::path& folder) {
            const std::string path = resolved(text_of(value), folder);
            place(scene, i) = read_picture(path);
            path_place(scene, i) = path;
        },
        [place, path_place](const SceneFile& scene, std::size_t i,
                            const std::filesystem::path& folder) {
            return path_value_of_read(!member_at(place, scene, i).rgba.empty(),
                                      member_at(path_place, scene, i), folder);
        });
}

} // namespace isocast::keys
