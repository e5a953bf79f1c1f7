// SPDX-License-Identifier: MPL-2.0
#include "apps/inputs.h"

#include "../volume/temporary_folder.h"
#include "program.h"
#include "volume/errors.h"

#include <gtest/gtest.h>

namespace isocast::test {
namespace {

TEST(Inputs, AreToldApartByNameAndExtension) {
    const TemporaryFolder folder;
    write_text(folder / "a.obj", "");
    write_text(folder / "a.vdb", "");
    write_text(folder / "a.slim", "");
    EXPECT_EQ(input_from(folder / "a.obj").kind, Input::Kind::MeshFile);
    EXPECT_EQ(input_from(folder / "a.vdb").kind, Input::Kind::FieldFile);
    for (const char* name : {"a.nrrd", "a.nhdr", "a.mhd", "a.mha", "a.nii", "a.nii.gz"}) {
        write_text(folder / name, "");
        EXPECT_EQ(input_from(folder / name).kind, Input::Kind::FieldFile) << name;
    }
    EXPECT_EQ(input_from(folder / "a.slim").kind, Input::Kind::SlimFile);
    EXPECT_EQ(input_from("mesh:knot").kind, Input::Kind::SampleMesh);
    EXPECT_EQ(input_from("mesh:knot").name, "knot");
    const Input field = input_from("field:marschner-lobb@41");
    EXPECT_EQ(field.kind, Input::Kind::BuiltinField);
    EXPECT_EQ(field.name, "marschner-lobb");
    EXPECT_EQ(field.samples_per_axis, 41);
    EXPECT_EQ(input_from("field:cube").samples_per_axis, 64);
    EXPECT_THROW(input_from("field:cube@"), InputError);
    EXPECT_THROW(input_from(folder / "b.obj"), InputError);
}

TEST(Inputs, AGridIsNamedAfterTheLastColon) {
    const TemporaryFolder folder;
    write_text(folder / "a:b.vdb", "");
    const std::string path = folder / "a:b.vdb";
    EXPECT_EQ(input_from(path).name, path);
    EXPECT_EQ(input_from(path).grid, "");
    EXPECT_EQ(input_from(path + ":density").name, path);
    EXPECT_EQ(input_from(path + ":density").grid, "density");
}

TEST(Numbers, AreTheWholeText) {
    EXPECT_EQ(number_from("-2.5e3"), -2500);
    EXPECT_EQ(integer_from("-12"), -12);
    for (const char* text : {"", " 1", "1 ", "1,5", "12abc", "0x10", "1e999", "nan", "inf"})
        EXPECT_THROW(number_from(text), UsageError) << text;
    for (const char* text : {"", "1.0", "12abc", "99999999999"})
        EXPECT_THROW(integer_from(text), UsageError) << text;
}

} // namespace
} // namespace isocast::test
