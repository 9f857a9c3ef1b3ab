// The verdict on scenes that are right, and on the same scenes spoilt as users spoil them.
#include "core/evidence/verdict.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "apps/run/judged_scene.h"
#include "core/evidence/offset_picture.h"
#include "core/support/error.h"
#include "core/support/parallel.h"
#include "core/synthetic/synthetic.h"

namespace burin {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;

SyntheticOptions Small(SyntheticKind kind, int seed) {
  SyntheticOptions options;
  options.scene = kind;
  options.seed = seed;
  options.width = 480;
  options.height = 360;
  options.samples_per_axis = 1;
  options.truth_point_count = 100;
  options.point_count = 100;
  return options;
}

const SyntheticScene& Made(SyntheticKind kind) {
  static std::map<SyntheticKind, SyntheticScene> made;
  if (made.count(kind) == 0) made[kind] = MakeSyntheticScene(Small(kind, 1));
  return made.at(kind);
}

SceneVerdict Judged(const Scene& scene, const TriangleMesh& mesh) {
  return JudgeScene(scene, mesh, SelectPairs(scene, mesh, PairsOptions()).pairs);
}

class VerdictOnScene : public ::testing::TestWithParam<SyntheticKind> {
 protected:
  const SyntheticScene& made() const { return Made(GetParam()); }
  SceneVerdict On(const std::function<void(Scene*)>& spoil) const {
    Scene scene = made().scene;
    spoil(&scene);
    return Judged(scene, made().init);
  }
  // Nothing that can be judged by is left, or it is called wrong.
  void ExpectNoRun(const std::function<void(Scene*)>& spoil) const {
    try {
      const SceneVerdict verdict = On(spoil);
      EXPECT_THAT(verdict.verdict, testing::AnyOf(Verdict::kWrong, Verdict::kCannotTell));
      EXPECT_NE(verdict.reason, "");
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr("no camera pair"));
    }
  }
};

INSTANTIATE_TEST_SUITE_P(Scenes, VerdictOnScene,
                         testing::Values(SyntheticKind::kRelief, SyntheticKind::kOccluders),
                         [](const auto& kind) { return NameOf(kind.param); });

TEST_P(VerdictOnScene, GoodIsCalledGood) {
  const SceneVerdict verdict = On([](Scene*) {});
  EXPECT_EQ(verdict.verdict, Verdict::kGood) << verdict.reason;
  EXPECT_GT(verdict.evidence.on_line, 0.85);
  EXPECT_GT(verdict.evidence.at_place, 0.85);
  EXPECT_LT(verdict.evidence.noise_px, 0.15);
  EXPECT_THAT(verdict.misfits, IsEmpty());
  EXPECT_EQ(verdict.views.size(), made().scene.views.size());
}

TEST_P(VerdictOnScene, WrongCamerasAreCalledWrong) {
  const std::vector<std::function<void(Scene*)>> spoilings = {
      [](Scene* scene) {  // principal point
        for (View& view : scene->views) view.camera.cx = view.camera.cy = 0;
      },
      [](Scene* scene) {  // K of an image of half the size
        for (View& view : scene->views) {
          view.camera.fx /= 2;
          view.camera.fy /= 2;
          view.camera.cx /= 2;
          view.camera.cy /= 2;
        }
      },
      [](Scene* scene) {  // names shifted by one
        const cv::Mat first = scene->views[0].gray;
        for (size_t v = 0; v + 1 < scene->views.size(); ++v) {
          scene->views[v].gray = scene->views[v + 1].gray;
        }
        scene->views.back().gray = first;
      }};
  for (const auto& spoil : spoilings) {
    const SceneVerdict verdict = On(spoil);
    EXPECT_EQ(verdict.verdict, Verdict::kWrong) << verdict.evidence.on_line;
    EXPECT_LT(verdict.evidence.on_line, 0.33);
    EXPECT_THAT(verdict.reason, HasSubstr("do not fit cameras and mesh"));
  }
}

TEST_P(VerdictOnScene, OnePhotographUnderAllNames) {
  const SceneVerdict same = On([](Scene* scene) {
    for (View& view : scene->views) view.gray = scene->views[0].gray;
  });
  EXPECT_EQ(same.verdict, Verdict::kWrong);
  EXPECT_THAT(same.reason, HasSubstr("the same photograph is in several views"));
  // Compressed anew it is no longer the same.
  const SceneVerdict alike = On([](Scene* scene) {
    for (size_t v = 1; v < scene->views.size(); ++v) {
      scene->views[v].gray = cv::Mat(scene->views[0].gray + static_cast<double>(v));
    }
  });
  EXPECT_EQ(alike.verdict, Verdict::kWrong);
  EXPECT_THAT(alike.reason, HasSubstr("do not fit cameras and mesh"));
}

TEST_P(VerdictOnScene, NoRunOnFocalLengthsInMillimetresOrInvertedPoses) {
  ExpectNoRun([](Scene* scene) {
    for (View& view : scene->views) view.camera.fx = view.camera.fy = 24;
  });
  ExpectNoRun([](Scene* scene) {
    for (View& view : scene->views) {
      const Eigen::Vector3d center = view.camera.Center();
      view.camera.rotation.transposeInPlace();
      view.camera.translation = center;
    }
  });
}

TEST_P(VerdictOnScene, OneWrongViewIsNamed) {
  const SceneVerdict turned = On([](Scene* scene) {
    Camera& camera = scene->views[3].camera;
    const Eigen::Vector3d center = camera.Center();
    const Eigen::AngleAxisd turn(3 * M_PI / 180, Eigen::Vector3d(1, 2, 2) / 3);
    camera.rotation = turn * camera.rotation;
    camera.translation = -camera.rotation * center;
  });
  EXPECT_THAT(turned.misfits, ElementsAre(3));
  EXPECT_TRUE(turned.views[3].misfit);
  EXPECT_EQ(turned.verdict, Verdict::kDoubtful);
  EXPECT_THAT(turned.reason, HasSubstr(made().scene.views[3].name));
  const SceneVerdict longer = On([](Scene* scene) {
    scene->views[2].camera.fx *= 1.05;
    scene->views[2].camera.fy *= 1.05;
  });
  EXPECT_THAT(longer.misfits, ElementsAre(2));
  const SceneVerdict swapped =
      On([](Scene* scene) { std::swap(scene->views[1].gray, scene->views[4].gray); });
  EXPECT_THAT(swapped.misfits, UnorderedElementsAre(1, 4));
}

TEST_P(VerdictOnScene, NoiseOfCamerasIsMeasured) {
  const auto noisy = [&](double px) {
    return On([px](Scene* scene) {
      const CounterRandom random(7, 0);
      for (size_t v = 0; v < scene->views.size(); ++v) {
        Camera& camera = scene->views[v].camera;
        camera = WithPoseNoise(camera, px, random, static_cast<int>(v));
      }
    });
  };
  for (const double px : {0.6, 1.0}) {
    const SceneVerdict verdict = noisy(px);
    EXPECT_EQ(verdict.verdict, Verdict::kDoubtful) << verdict.reason;
    EXPECT_GT(verdict.evidence.noise_px, 0.6 * px);  // of eight cameras it varies by itself
    EXPECT_LT(verdict.evidence.noise_px, 1.8 * px);
  }
  EXPECT_EQ(noisy(4).verdict, Verdict::kWrong);
}

TEST_P(VerdictOnScene, MeshThatDoesNotFitIsToldFromCameras) {
  const auto moved = [&](double share) {
    TriangleMesh mesh = made().init;
    const double step = share * BoundingDiagonal(mesh);
    for (Eigen::Vector3d& vertex : mesh.vertices) vertex.z() += step;
    return Judged(made().scene, mesh);
  };
  const SceneVerdict near = moved(-0.02);
  EXPECT_NE(near.verdict, Verdict::kWrong) << near.reason;
  const SceneVerdict far = moved(-0.1);
  EXPECT_EQ(far.verdict, Verdict::kWrong);
  EXPECT_THAT(far.reason, HasSubstr("the mesh does not fit")) << far.evidence.on_line;
}

TEST(Verdict, SmallPhotographsCannotBeJudged) {
  SyntheticOptions options = Small(SyntheticKind::kRelief, 1);
  options.width = 240;
  options.height = 180;
  const SyntheticScene made = MakeSyntheticScene(options);
  const SceneVerdict verdict = Judged(made.scene, made.init);
  EXPECT_EQ(verdict.verdict, Verdict::kCannotTell);
  EXPECT_THAT(verdict.reason, HasSubstr("240 px"));
}

TEST(Verdict, SameForAnyNumberOfThreads) {
  const SyntheticScene& made = Made(SyntheticKind::kOccluders);
  const auto with = [&](int threads) {
    const ThreadScope scope(threads);
    return Judged(made.scene, made.init);
  };
  const SceneVerdict one = with(1);
  const SceneVerdict many = with(5);
  EXPECT_EQ(one.evidence.on_line, many.evidence.on_line);
  EXPECT_EQ(one.evidence.at_place, many.evidence.at_place);
  EXPECT_EQ(one.evidence.noise_px, many.evidence.noise_px);
  ASSERT_EQ(one.matches.size(), many.matches.size());
  EXPECT_EQ(cv::norm(OffsetPicture(one, made.scene), OffsetPicture(many, made.scene)), 0);
}

TEST(Verdict, MaskedPixelsAreInNoWindow) {
  Scene scene = Made(SyntheticKind::kRelief).scene;
  for (View& view : scene.views) {
    view.mask = cv::Mat1b(view.camera.height, view.camera.width, 255);
    view.mask.colRange(0, view.camera.width / 2).setTo(0);
    view.gray = view.gray.clone();
    view.gray.colRange(0, view.camera.width / 2).setTo(77);
  }
  const SceneVerdict verdict = Judged(scene, Made(SyntheticKind::kRelief).init);
  ASSERT_GT(verdict.matches.size(), 30U);
  for (const WindowMatch& match : verdict.matches) {
    EXPECT_GT(match.place.x(), scene.views[0].camera.width / 2.0 + 5);
  }
  EXPECT_NE(verdict.verdict, Verdict::kWrong) << verdict.reason;
}

}  // namespace
}  // namespace burin
