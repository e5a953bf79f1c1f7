// Each hard case is a test of its name; `isocast selftest --stability` prints them as a table.
// SPDX-License-Identifier: MPL-2.0
#include "stability/cases.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

namespace isocast::stability {

void PrintTo(const Case& a_case, std::ostream* out) {
    *out << a_case.name;
}

namespace {

class Stability : public testing::TestWithParam<Case> {
protected:
    static void SetUpTestSuite() {
        devices = std::make_unique<Devices>(std::filesystem::path(ISOCAST_SOURCE_DIR) / "shaders");
    }
    static void TearDownTestSuite() { devices.reset(); }

    static std::unique_ptr<Devices> devices; // one context for all
};
std::unique_ptr<Devices> Stability::devices;

TEST_P(Stability, KeepsItsBound) {
    const Case& a_case = GetParam();
    try {
        const Worst found = a_case.run(*devices);
        EXPECT_GT(found.checked, 0) << "nothing was compared";
        EXPECT_LE(found.error, a_case.bound) << a_case.compares << "; " << a_case.bound_from;
    } catch (const Skip& skip) {
        GTEST_SKIP() << skip.what();
    }
}

INSTANTIATE_TEST_SUITE_P(Cases, Stability, testing::ValuesIn(all_cases()), [](const auto& test) {
    std::string name = test.param.name;
    std::ranges::replace_if(
        name, [](unsigned char c) { return std::isalnum(c) == 0; }, '_');
    return name;
});

TEST(StabilityCases, HaveNamesOfTheirOwnAndSayWhatTheyCompareAndWhy) {
    std::set<std::string> names, without_backend;
    for (const Case& a_case : all_cases()) {
        EXPECT_TRUE(names.insert(a_case.name).second) << a_case.name;
        EXPECT_FALSE(a_case.compares.empty() || a_case.bound_from.empty()) << a_case.name;
        std::string_view name = a_case.name;
        for (const std::string_view word : {".osmesa", ".egl", ".double", ".float"})
            if (name.ends_with(word)) name.remove_suffix(word.size());
        without_backend.emplace(name);
    }
    EXPECT_GE(without_backend.size(), 120U); // as was asked for, whatever they run in
}

TEST(StabilityVerdict, NeedsSomethingComparedAndNoErrorBeyondTheBound) {
    const Case a_case{.name = "", .compares = "", .bound = 1, .bound_from = "", .run = {}};
    Worst worst;
    EXPECT_FALSE(passes(a_case, worst));
    worst.see(1);
    EXPECT_TRUE(passes(a_case, worst));
    worst.see(std::nan(""));
    worst.see(0);
    EXPECT_FALSE(passes(a_case, worst));
    Worst wrong;
    wrong.must(true);
    EXPECT_TRUE(passes(a_case, wrong));
    wrong.must(false);
    EXPECT_FALSE(passes(a_case, wrong));
}

} // namespace
} // namespace isocast::stability
