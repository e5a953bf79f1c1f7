// Many more damaged files: minutes.
// SPDX-License-Identifier: MPL-2.0
#include "damaged_molecules.h"

namespace isocast::test {
namespace {

TEST(MoleculeErrors, ManyDamagedFilesAreReadOrRefused) {
    expect_read_or_refused(300'000, 2);
}

} // namespace
} // namespace isocast::test
