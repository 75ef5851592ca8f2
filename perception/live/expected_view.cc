#include "perception/live/expected_view.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "perception/live/projected_body.h"

namespace cwm::perception {
namespace {

// Joins rectangles as long as that makes fewer pixels to render, since a pixel in several of them
// is rendered several times.
void JoinRectangles(std::vector<PixelRectangle>& rectangles) {
  std::erase_if(rectangles, [](const PixelRectangle& rectangle) { return rectangle.empty(); });
  for (std::size_t i = 0; i < rectangles.size();) {
    const auto joined = std::find_if(
        rectangles.begin(), rectangles.begin() + static_cast<std::ptrdiff_t>(i),
        [&](const PixelRectangle& other) {
          return Hull(rectangles[i], other).area() <= rectangles[i].area() + other.area();
        });
    if (joined == rectangles.begin() + static_cast<std::ptrdiff_t>(i)) {
      ++i;
      continue;
    }
    *joined = Hull(rectangles[i], *joined);
    std::swap(rectangles[i], rectangles.back());
    rectangles.pop_back();
    i = static_cast<std::size_t>(joined - rectangles.begin());  // it may meet others now
  }
}

}  // namespace

struct ExpectedView::State {
  struct RenderedBody {
    BodyId id = kNoBody;
    Pose X_WB = Pose::Identity();
    std::shared_ptr<const HybridModel> model = nullptr;
    ProjectedBody projected = {};
  };

  bool was_updated = false;
  Pose X_WC = Pose::Identity();
  std::vector<RenderedBody> bodies;  // by ascending id
  std::vector<float> inverse_depth;

  // Takes over the bodies of the same pose and model; projects all others.
  void Take(std::vector<const KnownBody*> known, const DepthCamera& camera, bool is_same_pose,
            std::vector<PixelRectangle>& changed);
};

void ExpectedView::State::Take(std::vector<const KnownBody*> known, const DepthCamera& camera,
                               bool is_same_pose, std::vector<PixelRectangle>& changed) {
  std::vector<RenderedBody> before = std::exchange(bodies, {});
  bodies.reserve(known.size());
  const Pose X_CW = X_WC.inverse();
  auto old = before.begin();
  const auto drop_before = [&](BodyId id) {
    for (; old != before.end() && old->id < id; ++old) changed.push_back(old->projected.bounds());
  };
  for (const KnownBody* body : known) {
    drop_before(body->id);
    const bool was_there = old != before.end() && old->id == body->id;
    if (is_same_pose && was_there && old->model == body->model &&
        old->X_WB.matrix() == body->X_WB.matrix()) {
      bodies.push_back(std::move(*old++));
      continue;
    }
    if (was_there) changed.push_back((old++)->projected.bounds());
    bodies.push_back({.id = body->id,
                      .X_WB = body->X_WB,
                      .model = body->model,
                      .projected = ProjectedBody(*body->model, X_CW * body->X_WB, camera)});
    changed.push_back(bodies.back().projected.bounds());
  }
  drop_before(kNoBody);
}

ExpectedView::ExpectedView(const DepthCamera& camera)
    : camera_(camera),
      depth_m_(camera.pixel_count(), std::numeric_limits<float>::infinity()),
      body_(camera.pixel_count(), kNoBody),
      state_(std::make_unique<State>()) {
  state_->inverse_depth.resize(camera.pixel_count(), 0);
}

ExpectedView::~ExpectedView() = default;

void ExpectedView::Update(std::span<const KnownBody> bodies, const Pose& X_WC) {
  const bool is_same_pose = state_->was_updated && state_->X_WC.matrix() == X_WC.matrix();
  state_->was_updated = true;
  state_->X_WC = X_WC;
  std::vector<const KnownBody*> known;
  known.reserve(bodies.size());
  for (const KnownBody& body : bodies) {
    if (body.kind != KnownBody::Kind::kMover) known.push_back(&body);
  }
  if (!std::ranges::is_sorted(known, {}, &KnownBody::id)) {
    std::ranges::sort(known, {}, &KnownBody::id);
  }

  changed_.clear();
  state_->Take(std::move(known), camera_, is_same_pose, changed_);
  if (is_same_pose) {
    JoinRectangles(changed_);
  } else {
    changed_.assign(1, {.u_end = camera_.width, .v_end = camera_.height});
  }

  float* const inverse = state_->inverse_depth.data();
  const InverseDepthBuffer buffer = {
      .width = camera_.width, .inverse_depth = inverse, .body = body_.data()};
  for (const PixelRectangle& rectangle : changed_) {
    const auto for_rows = [&](const auto& change) {
      for (int v = rectangle.v_begin; v < rectangle.v_end; ++v) {
        const std::size_t row = static_cast<std::size_t>(v) * camera_.width;
        change(row + rectangle.u_begin, row + rectangle.u_end);
      }
    };
    for_rows([&](std::size_t begin, std::size_t end) {
      std::fill(inverse + begin, inverse + end, 0.F);
      std::fill(body_.data() + begin, body_.data() + end, kNoBody);
    });
    for (const State::RenderedBody& body : state_->bodies) {
      body.projected.Draw(body.id, rectangle, buffer);
    }
    for_rows([&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) depth_m_[i] = 1 / inverse[i];
    });
  }
}

PixelRectangle ExpectedView::BoundsOf(BodyId id) const {
  const auto found = std::ranges::lower_bound(state_->bodies, id, {}, &State::RenderedBody::id);
  return found != state_->bodies.end() && found->id == id ? found->projected.bounds()
                                                          : PixelRectangle();
}

}  // namespace cwm::perception
