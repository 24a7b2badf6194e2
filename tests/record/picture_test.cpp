#include "baton/record/picture.hpp"
#include "tests/support/temp.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "baton/ik/stand.hpp"
#include "baton/model/error.hpp"
#include "baton/model/world.hpp"
#include "tests/support/robots.hpp"

namespace baton {
namespace {

class PictureTest : public testing::Test {
 protected:
  PictureTest() {
    const RobotModel& robot = test::robot("mighty");
    const World world = World::load("flat");
    const std::string text = world.compose(robot, 0.001);
    const SpecPtr spec(mj_parseXMLString(text.c_str(), nullptr, nullptr, 0));
    model_ = compile_model(*spec, "flat with mighty");
    data_.reset(mj_makeData(model_.get()));
    const Posture home = stand(robot, world.site("start"), robot.profile().stance.com_height);
    std::copy_n(home.q.data(), home.q.size(), data_->qpos);
    mj_forward(model_.get(), data_.get());
  }
  std::filesystem::path file(const std::string& name) const {
    return std::filesystem::path(test::temp_folder()) / name;
  }

  ModelPtr model_;
  DataPtr data_;
};

int colours(const Image& image) {
  std::set<int> seen;
  for (std::size_t i = 0; i + 2 < image.rgb.size(); i += 3)
    seen.insert(image.rgb[i] << 16 | image.rgb[i + 1] << 8 | image.rgb[i + 2]);
  return static_cast<int>(seen.size());
}

/// OpenGL keeps traces of the picture before: a few bytes on edges may differ between equal scenes.
constexpr int kTraces = 30;

int different(const Image& a, const Image& b) {
  int n = 0;
  for (std::size_t i = 0; i < a.rgb.size(); ++i)
    n += a.rgb[i] != b.rgb[i] ? 1 : 0;
  return n;
}

TEST_F(PictureTest, ShowsTheRobotAndComesBackFromItsFile) {
  Picture picture(*model_, 200, 150);
  const Image shown = picture.render(*data_, "overview");
  EXPECT_EQ(shown.width, 200);
  EXPECT_EQ(shown.height, 150);
  EXPECT_GT(colours(shown), 100);
  // The sky is above, the floor below: bright blue-grey at the top.
  const std::uint8_t* top = shown.row(2);
  EXPECT_GT(top[2], top[0]);

  picture.save(file("picture.png"));
  const Image read = load_png(file("picture.png"));
  EXPECT_EQ(read.width, 200);
  EXPECT_EQ(read.height, 150);
  EXPECT_EQ(read.rgb, shown.rgb);

  data_->qpos[2] += 5.0;  // without the robot it is another picture
  mj_forward(model_.get(), data_.get());
  EXPECT_GT(different(picture.render(*data_, "overview"), shown), 1000);
}

TEST_F(PictureTest, IsNotBoundToTheModelsOffScreenSize) {
  const int width = model_->vis.global.offwidth;
  Picture picture(*model_, width + 40, 50);
  const Image& shown = picture.render(*data_, FreeCamera{{0, 0, 0.25}, 1.2, 150.0, -15.0});
  EXPECT_EQ(shown.width, width + 40);
  EXPECT_GT(colours(shown), 100);
  EXPECT_EQ(model_->vis.global.offwidth, width);
}

TEST_F(PictureTest, ShowsMarksUntilTheyAreCleared) {
  Picture picture(*model_, 160, 120);
  const FreeCamera camera{{0, 0, 0.2}, 1.2, 150.0, -15.0};
  const Image plain = picture.render(*data_, camera);
  picture.add_point({0.2, 0.2, 0.2}, 0.03, {1, 0, 0, 1});
  const int point = different(picture.render(*data_, camera), plain);
  EXPECT_GT(point, 2 * kTraces);
  std::vector<Vec3> path;
  for (int k = 0; k < 4500; ++k)
    path.emplace_back(-0.3 + 1e-4 * k, -0.2, 0.1);  // more than a scene usually holds
  picture.add_path(path, 0.01, {0, 0, 1, 1});
  EXPECT_GT(different(picture.render(*data_, camera), plain), point + 2 * kTraces);
  picture.clear_marks();
  EXPECT_LT(different(picture.render(*data_, camera), plain), kTraces);
}

TEST_F(PictureTest, TwoAtATimeDoNotDisturbEachOther) {
  Picture small(*model_, 80, 60);
  const Image before = small.render(*data_, "overview");
  {
    Picture large(*model_, 160, 120);
    (void)large.render(*data_, "follow");
    EXPECT_LT(different(small.render(*data_, "overview"), before), kTraces);
  }
  Picture moved = std::move(small);
  EXPECT_LT(different(moved.render(*data_, "overview"), before), kTraces);
}

TEST_F(PictureTest, SaysWhatIsWrong) {
  EXPECT_THROW(Picture(*model_, 0, 10), std::invalid_argument);
  EXPECT_THROW(Picture(*model_, 10, 100000), std::invalid_argument);
  Picture picture(*model_, 40, 30);
  EXPECT_THROW(picture.render(*data_, "no such camera"), InputError);
  EXPECT_THROW(picture.save("/nowhere/at/all.png"), InputError);
  EXPECT_THROW((void)load_png("/nowhere/at/all.png"), InputError);
}

TEST(Montage, PutsPicturesSideBySide) {
  const Image red{2, 2, {255, 0, 0, 255, 0, 0, 255, 0, 0, 255, 0, 0}};
  const Image blue{2, 4, std::vector<std::uint8_t>{0, 0, 255, 0, 0, 255, 0, 0, 255, 0, 0, 255,
                                                   0, 0, 255, 0, 0, 255, 0, 0, 255, 0, 0, 255}};
  const std::vector<Image> three{red, blue, red};
  const Image row = montage(three, 0, 1);
  EXPECT_EQ(row.width, 8);
  EXPECT_EQ(row.height, 4);
  EXPECT_EQ(row.row(0)[1], 255);          // white above the smaller one
  EXPECT_EQ(row.row(1)[1], 0);            // red
  EXPECT_EQ(row.row(1)[2 * 3 + 1], 255);  // gap
  EXPECT_EQ(row.row(0)[3 * 3 + 2], 255);  // blue
  EXPECT_EQ(row.row(0)[3 * 3], 0);
  const Image grid = montage(three, 2, 0);
  EXPECT_EQ(grid.width, 4);
  EXPECT_EQ(grid.height, 8);
  EXPECT_TRUE(montage({}).rgb.empty());
}

}  // namespace
}  // namespace baton
