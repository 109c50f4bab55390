// Methods can be told apart in plots.
#include "app/measure/method_looks.hpp"

#include <gtest/gtest.h>

#include <set>
#include <utility>

#include "pierce/error.hpp"

namespace pierce::app {
namespace {

TEST(MethodLooksTest, NoTwoMethodsLookTheSame) {
    std::set<std::string> names;
    std::set<std::pair<std::string, bool>> looks;
    for (const MethodLook& look : method_looks()) {
        EXPECT_TRUE(names.insert(look.name).second) << look.name;
        EXPECT_TRUE(looks.insert({look.colour, look.ours}).second) << look.name;
        EXPECT_EQ(&look_of_method(look.name), &look);
    }
    EXPECT_GT(names.size(), 10u);
    EXPECT_THROW(look_of_method("sat"), InputError);
}

}  // namespace
}  // namespace pierce::app
