// What every field source gets from its copy_box.
// SPDX-License-Identifier: MPL-2.0
#include "volume/field_source.h"

namespace isocast {

float sample(const FieldSource& field, const Index3& index) {
    float value = 0;
    field.copy_box({index, (index.array() + 1).matrix()}, 0, {&value, 1});
    return value;
}

} // namespace isocast
