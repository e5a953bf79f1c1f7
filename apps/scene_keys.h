// The one table of a scene's keys: it drives parsing, saving, --set, errors and docs/scenes.md.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "apps/scene_file.h"

#include <functional>
#include <optional>
#include <variant>

namespace isocast {

/// A value as TOML writes it.
using SceneValue = std::variant<bool, std::int64_t, double, std::string, std::vector<double>,
                                std::vector<std::string>>;

/// One key of a table.
struct SceneKey {
    std::string name;
    std::string type;    // what values it takes, for people
    std::string initial; // its value in a new scene; empty for none
    std::string help;
    bool is_number;
    /// Sets it in element `i` of the table (0 where there is one).
    ///
    /// folder  that paths are relative to
    /// throws  UsageError for a value of the wrong kind; InputError for a file that cannot be used
    std::function<void(SceneFile&, std::size_t i, const SceneValue&,
                       const std::filesystem::path& folder)>
        set;
    /// What `set` takes to make element `i` as it is; nothing where nothing is said of it.
    ///
    /// folder  that paths are written relative to where they lie below it
    /// throws  InputError for what was put into the scene without the file that it is from
    std::function<std::optional<SceneValue>(const SceneFile&, std::size_t i,
                                            const std::filesystem::path& folder)>
        get;
    /// Makes it what it is in a new scene; empty where that is not one member's matter.
    std::function<void(SceneFile&, std::size_t i)> reset = {};
};

/// A table of a scene file, or an array of such.
struct SceneTable {
    std::string name; // "effects.contours"
    std::string help;
    std::vector<SceneKey> keys;
    // Of arrays alone.
    std::function<std::size_t(const SceneFile&)> count = {};
    std::function<void(SceneFile&, std::size_t)> resize = {};

    bool is_array() const { return static_cast<bool>(count); }
    const SceneKey* key(std::string_view name) const;
};

/// Every table that a scene can have.
std::vector<SceneTable> scene_tables();
/// Those of effects.
std::vector<SceneTable> effect_tables();

/// As a scene file writes it: "[camera]" or "[[light]]".
std::string header_of(const SceneTable& table);

/// "eye, target, up": what a message lists.
std::string known_keys(const SceneTable& table);

/// As TOML writes it; numbers with as many digits as give them back.
std::string written(const SceneValue& value);

/// The reference of docs/scenes.md, in Markdown.
std::string scene_reference();

} // namespace isocast
