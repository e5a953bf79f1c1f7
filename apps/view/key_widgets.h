// A widget for each kind of key.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "apps/scene_keys.h"

namespace isocast::view {

/// Shows a key's value and lets it be changed.
///
/// value       that it has, if any
/// is_at_once  changes count while the mouse is down; else when it is let go
/// text        what is being typed, kept between frames
/// returns     the new value, if it was changed
std::optional<SceneValue> key_widget(const SceneKey& key, const std::optional<SceneValue>& value,
                                     bool is_at_once, std::string& text);

} // namespace isocast::view
