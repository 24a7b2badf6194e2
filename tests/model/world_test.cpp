#include "baton/model/world.hpp"
#include "tests/support/temp.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "baton/model/error.hpp"
#include "tests/support/random.hpp"
#include "tests/support/robots.hpp"

namespace baton {
namespace {

using test::Random;
using testing::AllOf;
using testing::HasSubstr;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::filesystem::path file_of(const std::string& name, const std::string& body) {
  const auto file = std::filesystem::path(test::temp_folder()) / ("baton_world_" + name + ".xml");
  std::ofstream(file) << "<mujoco model=\"" << name << "\"><compiler angle=\"radian\"/><worldbody>\n"
                      << body << "</worldbody></mujoco>\n";
  return file;
}

const std::string kStart = "<site name=\"start\" pos=\"0 0 0\"/>\n";

/// What the ground is made of, described anew: every query below is answered from this alone.
struct Block {
  bool plane = false;
  Vec3 centre = Vec3::Zero();
  Mat3 R = Mat3::Identity();
  Vec3 half = Vec3::Zero();

  [[nodiscard]] std::string mjcf(int number) const {
    const Eigen::Quaterniond q(R);
    std::ostringstream text;
    text.precision(17);
    text << "<geom name=\"ground_" << number << "\" type=\"" << (plane ? "plane" : "box") << "\" pos=\""
         << centre.transpose() << "\" quat=\"" << q.w() << " " << q.x() << " " << q.y() << " " << q.z() << "\" size=\""
         << half.x() << " " << half.y() << " " << (plane ? 0.1 : half.z()) << "\"/>\n";
    return text.str();
  }

  /// A point of the upper face by its two coordinates, −1…1.
  [[nodiscard]] Vec3 top(double u, double v) const {
    return centre + R * Vec3(u * half.x(), v * half.y(), plane ? 0.0 : half.z());
  }

  /// Height of the upper face above a place; nothing beside it.
  [[nodiscard]] std::optional<double> height(const Vec2& at) const {
    // The vertical line meets the face where the coordinate along the normal is that of the face.
    const Vec3 normal = R.col(2);
    const Vec3 on = top(0, 0);
    const double z = on.z() - (normal.head<2>().dot(at - on.head<2>())) / normal.z();
    const Vec3 local = R.transpose() * (Vec3(at.x(), at.y(), z) - on);
    if (std::abs(local.x()) > half.x() || std::abs(local.y()) > half.y()) return std::nullopt;
    return z;
  }
};

struct Ground {
  std::vector<Block> blocks;

  [[nodiscard]] std::string mjcf() const {
    std::string text = kStart;
    for (std::size_t i = 0; i < blocks.size(); ++i)
      text += blocks[i].mjcf(static_cast<int>(i));
    return text;
  }

  /// The highest face, and its height.
  [[nodiscard]] std::optional<std::pair<const Block*, double>> highest(const Vec2& at) const {
    std::optional<std::pair<const Block*, double>> found;
    for (const Block& block : blocks) {
      const std::optional<double> z = block.height(at);
      if (z && (!found || *z > found->second)) found = {&block, *z};
    }
    return found;
  }

  /// Whether an edge of any face passes within `near` of the place, seen from above.
  [[nodiscard]] bool edge_within(const Vec2& at, double near) const {
    for (const Block& block : blocks) {
      const std::array<Vec2, 4> corner{block.top(-1, -1).head<2>(), block.top(1, -1).head<2>(),
                                       block.top(1, 1).head<2>(), block.top(-1, 1).head<2>()};
      for (std::size_t i = 0; i < 4; ++i) {
        if (distance(at, corner[i], corner[(i + 1) % 4]) < near) return true;
      }
    }
    return false;
  }

  static double distance(const Vec2& at, const Vec2& a, const Vec2& b) {
    const double s = std::clamp((at - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
    return (at - a - s * (b - a)).norm();
  }
};

enum class Kind { level, tilted };

/// A floor of finite size (or none) and boxes on it, apart, side by side and over each other.
Ground random_ground(Random& random, Kind kind) {
  Ground ground;
  if (random(0, 1) < 0.7) {
    ground.blocks.push_back({true, Vec3(0, 0, 0), rotation_z(random(0, 3)), Vec3(random(0.2, 0.8), 0.5, 0)});
  }
  for (int k = 0; k < 4; ++k) {
    Block box;
    box.half = {random(0.05, 0.3), random(0.05, 0.3), random(0.01, 0.05)};
    box.centre = {random(-0.4, 0.4), random(-0.4, 0.4), random(-0.02, 0.06)};
    box.R = rotation_z(random(-3, 3));
    if (kind == Kind::tilted) box.R = rotation_exp(Vec3(random(-0.15, 0.15), random(-0.15, 0.15), 0)) * box.R;
    ground.blocks.push_back(box);
  }
  return ground;
}

World world_of(const Ground& ground) {
  return World(file_of("random", ground.mjcf()));
}

/// A sole anywhere.
ConvexPolygon random_sole(Random& random) {
  const Vec2 half(random(0.03, 0.06), random(0.02, 0.05));
  const Mat3 R = rotation_z(random(-3, 3));
  const Vec2 at = random.horizontal(0.5).head<2>();
  std::vector<Vec2> corners;
  for (const double u : {-1.0, 1.0}) {
    for (const double v : {-1.0, 1.0})
      corners.push_back(at + (R * Vec3(u * half.x(), v * half.y(), 0)).head<2>());
  }
  return ConvexPolygon::hull(corners);
}

/// Corners moved away from the middle of a rectangle, so that every side moves out by `by`.
std::vector<Vec2> widened(const ConvexPolygon& rectangle, double by) {
  const auto& v = rectangle.vertices();
  std::vector<Vec2> corners;
  for (std::size_t i = 0; i < v.size(); ++i) {
    const Vec2 a = (v[i] - v[(i + 1) % v.size()]).normalized();
    const Vec2 b = (v[i] - v[(i + v.size() - 1) % v.size()]).normalized();
    corners.push_back(v[i] + by * (a + b));
  }
  return corners;
}

/// Points that cover a rectangle, its rim among them.
std::vector<Vec2> cover(const std::vector<Vec2>& corners, int per_side) {
  std::vector<Vec2> points;
  for (int i = 0; i <= per_side; ++i) {
    for (int j = 0; j <= per_side; ++j) {
      const double u = static_cast<double>(i) / per_side;
      const double v = static_cast<double>(j) / per_side;
      points.push_back(corners[0] + u * (corners[1] - corners[0]) + v * (corners[3] - corners[0]));
    }
  }
  return points;
}

TEST(World, FlatIsFlatEverywhere) {
  const World world = World::load("flat");
  Random random(1);
  for (int trial = 0; trial < 2000; ++trial) {
    const Vec2 at = random.horizontal(50.0).head<2>();
    const std::optional<GroundPoint> ground = world.ground(at);
    ASSERT_TRUE(ground);
    EXPECT_EQ(ground->height, 0.0);
    EXPECT_EQ(ground->normal, Vec3::UnitZ());
    EXPECT_GT(ground->edge, 100.0);
  }
  EXPECT_EQ(world.site("start").p, Vec3::Zero());
}

TEST(World, RoomHasStageTreadAndFloor) {
  const World world = World::load("room");
  Random random(2);
  for (int trial = 0; trial < 20000; ++trial) {
    const Vec2 at(random(-0.6, 0.9), random(-0.5, 0.5));
    // By the drawing at the top of worlds/room.xml.
    double height = 0.0;
    double edge = kInfinity;
    const auto inside = [&](double x0, double x1) { return at.x() >= x0 && at.x() <= x1 && std::abs(at.y()) <= 0.30; };
    const auto rim = [&](double x0, double x1) {
      return std::min({at.x() - x0, x1 - at.x(), 0.30 - std::abs(at.y())});
    };
    const auto beside = [&](double x0, double x1) {
      return Vec2(std::max({x0 - at.x(), at.x() - x1, 0.0}), std::max(std::abs(at.y()) - 0.30, 0.0)).norm();
    };
    if (inside(-0.40, 0.12)) {
      height = 0.030;
      edge = rim(-0.40, 0.12);
    } else if (inside(0.12, 0.24)) {
      height = 0.015;
      edge = rim(0.12, 0.24);
    } else {
      edge = std::min(beside(-0.40, 0.12), beside(0.12, 0.24));
    }
    const std::optional<GroundPoint> ground = world.ground(at);
    ASSERT_TRUE(ground);
    if (edge < 1e-6) continue;
    ASSERT_NEAR(ground->height, height, 1e-12) << at.transpose();
    ASSERT_NEAR(ground->edge, edge, 1e-9) << at.transpose();
    ASSERT_LT((ground->normal - Vec3::UnitZ()).norm(), 1e-12);
  }
  EXPECT_NEAR(world.site("door_B").p.z(), 0.36, 1e-12);
}

TEST(World, KnowsTheHighestFaceAtEveryPlace) {
  Random random(3);
  int on_ground = 0;
  int beside = 0;
  for (int trial = 0; trial < 60; ++trial) {
    const Ground ground = random_ground(random, trial % 2 == 0 ? Kind::level : Kind::tilted);
    const World world = world_of(ground);
    ASSERT_EQ(world.faces().size(), ground.blocks.size());
    for (int probe = 0; probe < 200; ++probe) {
      const Vec2 at = random.horizontal(0.9).head<2>();
      if (ground.edge_within(at, 1e-6)) continue;
      const auto expected = ground.highest(at);
      const std::optional<GroundPoint> found = world.ground(at);
      ASSERT_EQ(found.has_value(), expected.has_value()) << at.transpose();
      ++(expected ? on_ground : beside);
      if (!expected) continue;
      ASSERT_NEAR(found->height, expected->second, 1e-9);
      ASSERT_LT((found->normal - expected->first->R.col(2)).norm(), 1e-9);
    }
  }
  EXPECT_GT(on_ground, 3000);
  EXPECT_GT(beside, 1000);
}

TEST(World, TheNearestGroundOfAHeightIsNearestOnAFaceAsHighThatNothingCoversThere) {
  constexpr double kTolerance = 0.004;
  Random random(11);
  int found = 0;
  int nowhere = 0;
  int covered = 0;
  for (int trial = 0; trial < 60; ++trial) {
    const Ground ground = random_ground(random, Kind::level);
    const World world = world_of(ground);
    for (int probe = 0; probe < 60; ++probe) {
      const Vec2 at = random.horizontal(0.6).head<2>();
      const Block& block =
          ground.blocks[static_cast<std::size_t>(random(0, static_cast<double>(ground.blocks.size())))];
      const double height = block.top(0, 0).z() + random(-0.002, 0.002);
      double nearest = std::numeric_limits<double>::infinity();
      bool sure = true;
      for (const Block& face : ground.blocks) {
        const double z = face.top(0, 0).z();
        sure = sure && std::abs(std::abs(z - height) - kTolerance) > 1e-9;
        if (std::abs(z - height) > kTolerance) continue;
        Vec3 local = face.R.transpose() * (Vec3(at.x(), at.y(), z) - face.top(0, 0));
        local = local.cwiseMax(-face.half).cwiseMin(face.half);
        const Vec2 place = (face.top(0, 0) + face.R * Vec3(local.x(), local.y(), 0)).head<2>();
        bool under = false;
        for (const Block& other : ground.blocks) {
          if (&other == &face || other.top(0, 0).z() <= z + kTolerance) continue;
          const Vec3 there = other.R.transpose() * (Vec3(place.x(), place.y(), 0) - other.top(0, 0));
          const double inside = std::min(other.half.x() - std::abs(there.x()), other.half.y() - std::abs(there.y()));
          under = under || inside > 0.0;
          sure = sure && std::abs(inside) > 1e-6;
        }
        covered += under ? 1 : 0;
        if (!under) nearest = std::min(nearest, (place - at).norm());
      }
      if (!sure) continue;
      const std::optional<Vec2> got = world.nearest_of_height(at, height, kTolerance);
      ASSERT_EQ(got.has_value(), std::isfinite(nearest));
      ++(got ? found : nowhere);
      if (!got) continue;
      ASSERT_NEAR((*got - at).norm(), nearest, 1e-9);
    }
  }
  EXPECT_GT(found, 1000);
  EXPECT_GT(nowhere, 50);
  EXPECT_GT(covered, 300);
}

TEST(World, AgreesWithARayFromAbove) {
  Random random(4);
  int hits = 0;
  for (int trial = 0; trial < 60; ++trial) {
    const Ground ground = random_ground(random, trial % 2 == 0 ? Kind::level : Kind::tilted);
    const World world = world_of(ground);
    const DataPtr data(mj_makeData(&world.mj()));
    mj_forward(&world.mj(), data.get());
    for (int probe = 0; probe < 200; ++probe) {
      const Vec2 at = random.horizontal(0.9).head<2>();
      if (ground.edge_within(at, 1e-3)) continue;
      const Vec3 from(at.x(), at.y(), 2.0);
      const Vec3 down(0, 0, -1);
      int geom = -1;
      const double depth = mj_ray(&world.mj(), data.get(), from.data(), down.data(), nullptr, 1, -1, &geom, nullptr);
      const std::optional<GroundPoint> found = world.ground(at);
      if (geom < 0) {
        ASSERT_FALSE(found);
        continue;
      }
      // A ray may meet the side of a tilted box, which nobody stands on.
      const std::optional<double> top = ground.blocks[static_cast<std::size_t>(geom)].height(at);
      if (!top) continue;
      ASSERT_TRUE(found);
      ASSERT_NEAR(found->height, 2.0 - depth, 1e-6);
      ++hits;
    }
  }
  EXPECT_GT(hits, 3000);
}

TEST(World, KnowsTheDistanceToTheNearestStep) {
  // On level faces: around a place, the height is the same up to the edge, and another beyond it (or the
  // face's own edge lies there, level with its neighbour).
  Random random(5);
  int checked = 0;
  for (int trial = 0; trial < 60; ++trial) {
    const Ground ground = random_ground(random, Kind::level);
    const World world = world_of(ground);
    for (int probe = 0; probe < 40; ++probe) {
      const Vec2 at = random.horizontal(0.6).head<2>();
      const std::optional<GroundPoint> found = world.ground(at);
      if (!found || found->edge < 2e-3) continue;
      ++checked;
      const auto height = [&](double r, double angle) {
        const auto there = ground.highest(at + r * Vec2(std::cos(angle), std::sin(angle)));
        return there ? there->second : -kInfinity;
      };
      for (int k = 0; k < 72; ++k) {
        const double angle = 2.0 * M_PI * k / 72;
        for (const double r : {0.3, 0.7, 0.999})
          ASSERT_NEAR(height(r * found->edge, angle), found->height, 1e-9);
      }
      ASSERT_TRUE(ground.edge_within(at, found->edge + 1e-6));
      ASSERT_FALSE(found->edge <= 0.0);
    }
  }
  EXPECT_GT(checked, 500);
}

TEST(World, KnowsTheHighestGroundUnderASole) {
  Random random(6);
  int something = 0;
  int nothing = 0;
  for (int trial = 0; trial < 60; ++trial) {
    const Ground ground = random_ground(random, trial % 2 == 0 ? Kind::level : Kind::tilted);
    const World world = world_of(ground);
    for (int probe = 0; probe < 30; ++probe) {
      const ConvexPolygon sole = random_sole(random);
      const auto sampled = [&](double by) {
        double highest = -kInfinity;
        for (const Vec2& point : cover(widened(sole, by), 40)) {
          const auto here = ground.highest(point);
          if (here) highest = std::max(highest, here->second);
        }
        return highest;
      };
      // Between what samples find and what they find a spacing farther out, on slopes of at most 0.22.
      constexpr double kSpacing = 3.5e-3;
      const double found = world.highest_under(sole);
      ASSERT_GE(found, sampled(0.0) - 1e-9);
      const double most = sampled(kSpacing);
      ASSERT_LE(found, most + 0.22 * kSpacing) << "trial " << trial;
      ++(std::isfinite(found) ? something : nothing);
    }
  }
  EXPECT_GT(something, 1000);
  EXPECT_GT(nothing, 50);
}

TEST(World, TakesAFootholdIfAndOnlyIfItIsFlatUnderTheWholeSole) {
  Random random(7);
  const Profile::Ground flat{0.002, 3.0 * M_PI / 180.0};
  constexpr double kEdge = 0.002;
  constexpr double kDoubt = 0.001;  // [m] of flatness and place
  std::map<bool, int> seen;
  int doubtful = 0;
  for (int trial = 0; trial < 70; ++trial) {
    Ground ground = random_ground(random, Kind::level);
    for (Block& block : ground.blocks) {
      // Some boxes lean about as much as is allowed, some are almost level with the floor.
      if (!block.plane && random(0, 1) < 0.4) {
        block.R = rotation_exp(Vec3(random(-0.06, 0.06), random(-0.06, 0.06), 0)) * block.R;
      }
      if (!block.plane && random(0, 1) < 0.3) block.centre.z() = random(-0.004, 0.004) - block.half.z();
    }
    const World world = world_of(ground);
    for (int probe = 0; probe < 40; ++probe) {
      const ConvexPolygon sole = random_sole(random);
      const auto centre = ground.highest(sole.centre());
      // The plane through the centre, and the worst point under the sole widened by `by`.
      const auto worst = [&](double by) {
        if (!centre) return kInfinity;
        const Vec3 normal = centre->first->R.col(2);
        double deviation = 0.0;
        for (const Vec2& point : cover(widened(sole, by), 70)) {
          const auto here = ground.highest(point);
          if (!here) return kInfinity;
          const Vec2 off = point - sole.centre();
          const double plane = centre->second - normal.head<2>().dot(off) / normal.z();
          deviation = std::max(deviation, std::abs(here->second - plane));
        }
        return deviation;
      };
      const double tilt = centre ? std::acos(std::min(1.0, centre->first->R(2, 2))) : kInfinity;
      const bool surely = worst(kEdge + kDoubt) < flat.flatness - kDoubt && tilt < flat.tilt - 1e-4;
      const bool never = worst(kEdge - kDoubt) > flat.flatness + kDoubt || tilt > flat.tilt + 1e-4;
      if (!surely && !never) {
        ++doubtful;
        continue;
      }
      const Foothold foothold = world.foothold(sole, flat, kEdge);
      ASSERT_EQ(foothold.flat, surely) << "trial " << trial << ", sole at " << sole.centre().transpose()
                                       << ": deviation " << foothold.deviation << ", sampled " << worst(kEdge - kDoubt)
                                       << " … " << worst(kEdge + kDoubt);
      ++seen[surely];
      if (!surely) continue;
      ASSERT_NEAR(foothold.height, centre->second, 1e-9);
      ASSERT_LT((foothold.normal - centre->first->R.col(2)).norm(), 1e-9);
      ASSERT_LE(foothold.deviation, flat.flatness);
    }
  }
  EXPECT_GT(seen[true], 300);
  EXPECT_GT(seen[false], 800);
  EXPECT_LT(doubtful, 500);
}

TEST(World, KeepsASoleAwayFromAnEdgeByTheMargin) {
  const World world = World::load("room");  // the stage ends at x = 0.12
  const Profile::Ground flat{0.002, 0.05};
  const double half = 0.05;
  for (const double edge : {0.0, 0.002, 0.01}) {
    for (const double beyond : {-1e-4, 1e-4}) {
      std::vector<Vec2> corners;
      const double x = 0.12 - half - edge + beyond;
      for (const double u : {-half, half}) {
        for (const double v : {-0.03, 0.03})
          corners.emplace_back(x + u, v);
      }
      EXPECT_EQ(world.foothold(ConvexPolygon::hull(corners), flat, edge).flat, beyond < 0.0)
          << "edge " << edge << ", beyond " << beyond;
    }
  }
}

TEST(World, FindsTheUpperSideOfABoxHoweverItLies) {
  Random random(8);
  for (int trial = 0; trial < 200; ++trial) {
    // A box on one of its six sides, then turned: the side that looks up is the one to stand on.
    Block box;
    box.half = {random(0.05, 0.2), random(0.05, 0.2), random(0.05, 0.2)};
    box.centre = {random(-1, 1), random(-1, 1), random(0, 1)};
    const double quarter = 0.5 * M_PI;
    const double turns = std::floor(random(0, 4));
    Mat3 lie = rotation_exp(Vec3(quarter * turns, 0, 0));
    if (trial % 3 == 0) lie = rotation_exp(Vec3(0, quarter * turns, 0));
    box.R = rotation_z(random(-3, 3)) * lie;
    const World world(file_of("lying", kStart + box.mjcf(0)));
    const double height = box.centre.z() + (box.R.cwiseAbs() * box.half).z();
    const std::optional<GroundPoint> found = world.ground(box.centre.head<2>());
    ASSERT_TRUE(found);
    ASSERT_NEAR(found->height, height, 1e-9);
    ASSERT_NEAR(found->normal.z(), 1.0, 1e-9);
  }
}

/// The message of the InputError that `make` throws.
template <typename Make>
std::string complaint_about(const Make& make) {
  try {
    static_cast<void>(make());
  } catch (const InputError& error) {
    return error.what();
  }
  ADD_FAILURE() << "no InputError";
  return "";
}

TEST(World, NamesWhatIsWrongWithAFile) {
  EXPECT_THAT(complaint_about([] { return World::load("nowhere"); }), AllOf(HasSubstr("nowhere"), HasSubstr("worlds")));
  EXPECT_THAT(complaint_about([] { return World::load("/no/such/place.xml"); }), HasSubstr("/no/such/place.xml"));
  const auto expect = [](const std::string& name, const std::string& body, const std::string& thing) {
    const auto file = file_of(name, body);
    EXPECT_THAT(complaint_about([&] { return World(file); }), AllOf(HasSubstr(file.string()), HasSubstr(thing)));
  };
  const std::string floor = "<geom name=\"ground\" type=\"plane\" size=\"1 1 0.1\"/>";
  expect("empty", kStart, "ground");
  expect("no_start", floor, "start");
  expect("ball", kStart + floor + "<geom name=\"ground_ball\" type=\"sphere\" size=\"0.1\"/>", "ground_ball");
  expect("wall", kStart + R"(<geom name="ground_wall" type="plane" size="1 1 0.1" zaxis="1 0 0"/>)", "ground_wall");
  expect("ceiling", kStart + R"(<geom name="ground_lid" type="plane" size="1 1 0.1" zaxis="0 0 -1"/>)", "ground_lid");
  expect("broken", kStart + "<geom name=\"ground\" type=\"plane\"", "");
  expect("unknown", kStart + floor + "<geom name=\"x\" type=\"potato\" size=\"1\"/>", "potato");
  expect("negative", kStart + floor + "<geom name=\"x\" type=\"box\" size=\"-1 1 1\"/>", "");
  const World fine(file_of("fine", kStart + floor));
  EXPECT_THAT(complaint_about([&] { return fine.site("door_Z"); }), HasSubstr("door_Z"));
}

class ComposeTest : public testing::TestWithParam<std::string> {
 protected:
  const RobotModel& robot_ = test::robot(GetParam());
};

INSTANTIATE_TEST_SUITE_P(Robots, ComposeTest, testing::ValuesIn(test::robot_names()), test::name_of_param);

TEST_P(ComposeTest, GivesHonestPhysics) {
  for (const char* name : {"flat", "room"}) {
    const World world = World::load(name);
    const ModelPtr m = compile_text(world.compose(robot_, 0.002), name);
    EXPECT_EQ(m->opt.timestep, 0.002);
    EXPECT_EQ(m->opt.integrator, mjINT_IMPLICITFAST);
    EXPECT_EQ(m->opt.cone, mjCONE_ELLIPTIC);
    EXPECT_EQ(m->opt.gravity[0], 0.0);
    EXPECT_EQ(m->opt.gravity[1], 0.0);
    EXPECT_EQ(m->opt.gravity[2], -kGravity);
    EXPECT_EQ(m->opt.disableflags, mjDSBL_AUTORESET);
    EXPECT_EQ(m->opt.enableflags & (mjENBL_INVDISCRETE | mjENBL_OVERRIDE), 0);
    EXPECT_EQ(m->neq, 0);
    EXPECT_EQ(m->nmocap, 0);
    EXPECT_EQ(m->ntendon, 0);
    EXPECT_EQ(m->opt.viscosity, 0.0);
    EXPECT_EQ(m->opt.density, 0.0);
    for (int b = 0; b < m->nbody; ++b)
      EXPECT_EQ(m->body_gravcomp[b], 0.0) << name_of(*m, mjOBJ_BODY, b);
    for (int j = 0; j < m->njnt; ++j) {
      EXPECT_EQ(m->jnt_stiffness[j], 0.0);
      EXPECT_FALSE(m->jnt_actgravcomp[j]);
    }
    const DataPtr data(mj_makeData(m.get()));
    for (int i = 0; i < m->nv; ++i)
      EXPECT_EQ(data->qfrc_applied[i], 0.0);
    for (int i = 0; i < 6 * m->nbody; ++i)
      EXPECT_EQ(data->xfrc_applied[i], 0.0);
  }
}

/// MuJoCo writes numbers with six digits.
constexpr double kDigits = 6e-6;

TEST_P(ComposeTest, KeepsNamesAndOrderOfTheRobot) {
  for (const char* name : {"flat", "room"}) {
    const World world = World::load(name);
    const ModelPtr m = compile_text(world.compose(robot_, 0.001), name);
    const mjModel& alone = robot_.mj();
    ASSERT_EQ(m->nq, alone.nq);
    ASSERT_EQ(m->nv, alone.nv);
    ASSERT_EQ(m->nu, alone.nu);
    for (const mjtObj type : {mjOBJ_BODY, mjOBJ_JOINT, mjOBJ_GEOM, mjOBJ_SITE, mjOBJ_ACTUATOR, mjOBJ_PAIR}) {
      const auto count = [type](const mjModel& model) {
        switch (type) {
          case mjOBJ_BODY:
            return model.nbody;
          case mjOBJ_JOINT:
            return model.njnt;
          case mjOBJ_GEOM:
            return model.ngeom;
          case mjOBJ_SITE:
            return model.nsite;
          case mjOBJ_ACTUATOR:
            return model.nu;
          default:
            return model.npair;
        }
      };
      for (const mjModel* part : {&alone, &world.mj()}) {
        for (int i = 0; i < count(*part); ++i) {
          const std::string thing = name_of(*part, type, i);
          EXPECT_TRUE(thing.empty() || mj_name2id(m.get(), type, thing.c_str()) >= 0) << thing;
        }
      }
    }
    for (int j = 0; j < alone.njnt; ++j) {
      const int there = mj_name2id(m.get(), mjOBJ_JOINT, name_of(alone, mjOBJ_JOINT, j).c_str());
      ASSERT_GE(there, 0);
      EXPECT_EQ(m->jnt_qposadr[there], alone.jnt_qposadr[j]);
      EXPECT_EQ(m->jnt_dofadr[there], alone.jnt_dofadr[j]);
      for (const int end : {0, 1}) {
        EXPECT_NEAR(m->jnt_range[2 * there + end], alone.jnt_range[2 * j + end], kDigits);
      }
      const int dof = alone.jnt_dofadr[j];
      const int dof_there = m->jnt_dofadr[there];
      EXPECT_NEAR(m->dof_damping[dof_there], alone.dof_damping[dof], kDigits * alone.dof_damping[dof]);
      EXPECT_NEAR(m->dof_armature[dof_there], alone.dof_armature[dof], kDigits * alone.dof_armature[dof]);
    }
    for (int b = 1; b < alone.nbody; ++b) {
      const int there = mj_name2id(m.get(), mjOBJ_BODY, name_of(alone, mjOBJ_BODY, b).c_str());
      EXPECT_NEAR(m->body_mass[there], alone.body_mass[b], kDigits * alone.body_mass[b]);
    }
    EXPECT_NEAR(m->body_subtreemass[0], robot_.mass(), kDigits * robot_.mass());
  }
}

TEST_P(ComposeTest, SavedTextIsTheVeryModel) {
  for (const char* name : {"flat", "room"}) {
    const World world = World::load(name);
    const std::string text = world.compose(robot_, 0.001);
    EXPECT_EQ(text, world.compose(robot_, 0.001));
    const ModelPtr model = compile_text(text, name);
    const auto file = std::filesystem::path(test::temp_folder()) / "baton_saved.xml";
    std::ofstream(file) << text;
    const SpecPtr spec = parse_model(file);
    const ModelPtr again = compile_model(*spec, name);
    ASSERT_EQ(again->nq, model->nq);
    ASSERT_EQ(again->nbody, model->nbody);
    ASSERT_EQ(again->ngeom, model->ngeom);
    ASSERT_EQ(again->npair, model->npair);
    for (int i = 0; i < model->nbody; ++i)
      EXPECT_EQ(again->body_mass[i], model->body_mass[i]);
    for (int i = 0; i < 3 * model->nbody; ++i) {
      EXPECT_EQ(again->body_inertia[i], model->body_inertia[i]);
      EXPECT_EQ(again->body_ipos[i], model->body_ipos[i]);
      EXPECT_EQ(again->body_pos[i], model->body_pos[i]);
    }
    for (int i = 0; i < 3 * model->ngeom; ++i) {
      EXPECT_EQ(again->geom_size[i], model->geom_size[i]);
      EXPECT_EQ(again->geom_pos[i], model->geom_pos[i]);
      EXPECT_EQ(again->geom_friction[i], model->geom_friction[i]);
    }
  }
}

TEST_P(ComposeTest, TwoThingsOfOneNameAreBadInput) {
  const std::string twin = name_of(robot_.mj(), mjOBJ_SITE, 0);
  const World world(
      file_of("twin", kStart + "<geom name=\"ground\" type=\"plane\" size=\"1 1 0.1\"/><site name=\"" + twin + "\"/>"));
  EXPECT_THAT(complaint_about([&] { return world.compose(robot_, 0.001); }), HasSubstr(twin));
}

}  // namespace
}  // namespace baton
