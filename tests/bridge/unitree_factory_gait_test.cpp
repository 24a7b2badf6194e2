/// How the factory gait of a Unitree G1 ends.
#include <gmock/gmock.h>

#include <stdexcept>
#include <string>

#include "bridge/unitree/factory_gait.hpp"
#include "tests/bridge/unitree_states.hpp"

namespace baton::unitree {
namespace {

using testing::HasSubstr;

/// A motion switcher that answers at random, and how the gait's end goes with it.
struct Switcher {
  std::string active = "ai";
  int releases_needed = 1;  ///< after which it is released
  double deaf = 0.0;        ///< share of requests that are not answered
  double wrong = 0.0;       ///< share of answers that are none
  int releases = 0;

  FactoryGait::State run(Random& random, FactoryGait& gait) {
    double t = 0.0;
    for (; gait.state() == FactoryGait::State::asking; t += 0.01) {
      if (t > 200.0) throw std::logic_error("it never ends");
      const std::optional<FactoryGait::Request> request = gait.next(t);
      if (!request || between(random, 0.0, 1.0) < deaf) continue;
      if (between(random, 0.0, 1.0) < wrong) {
        constexpr const char* kWrong[] = {"", "{", "[]", "null", "{\"name\": 3}", "{\"form\": \"0\"}"};
        gait.answer(request->id, random() % 2 == 0 ? 0 : 7001, kWrong[random() % std::size(kWrong)], t);
        continue;
      }
      gait.answer(request->id + 1, 0, R"({"form":"0","name":""})", t);  // somebody else's
      if (request->api == FactoryGait::Api::release_mode) {
        if (++releases >= releases_needed) active.clear();
        gait.answer(request->id, 0, "", t);
      } else {
        gait.answer(request->id, 0, R"({"form":"0","name":")" + active + "\"}", t);
      }
    }
    return gait.state();
  }
};

TEST(UnitreeFactoryGait, IsReleasedOrItSaysWhyNot) {
  int released = 0;
  int failed = 0;
  for (std::uint64_t seed = 0; seed < 5000; ++seed) {
    Random random(seed);
    Switcher switcher{.active = seed % 3 == 0 ? "" : "ai",
                      .releases_needed = static_cast<int>(random() % 8),
                      .deaf = between(random, 0.0, 0.8),
                      .wrong = between(random, 0.0, 0.5)};
    FactoryGait gait(static_cast<std::int64_t>(random() >> 8U));
    if (switcher.run(random, gait) == FactoryGait::State::released) {
      ++released;
      ASSERT_EQ(switcher.active, "") << "what is said to be released is";
    } else {
      ++failed;
      ASSERT_FALSE(gait.why().empty());
    }
  }
  EXPECT_GT(released, 1000);
  EXPECT_GT(failed, 500);
}

TEST(UnitreeFactoryGait, ThatStaysIsNamed) {
  Random random(1);
  Switcher switcher{.releases_needed = 1000};
  FactoryGait gait(1);
  EXPECT_EQ(switcher.run(random, gait), FactoryGait::State::failed);
  EXPECT_EQ(gait.why(), "the factory gait 'ai' is still active after it was told 5 times to end");
  EXPECT_EQ(switcher.releases, 5);
}

TEST(UnitreeFactoryGait, IsNotSaidToBeReleasedByASwitcherThatDoesNotAnswer) {
  Random random(1);
  Switcher switcher{.deaf = 1.0};
  FactoryGait gait(1);
  EXPECT_EQ(switcher.run(random, gait), FactoryGait::State::failed);
  EXPECT_THAT(gait.why(), HasSubstr("the motion switcher does not answer"));
}

}  // namespace
}  // namespace baton::unitree
