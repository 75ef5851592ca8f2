#include "perception/live/compare_frame.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <numeric>

#include "perception/live/pixel_lanes.h"
#include "perception/live/pixel_rays.h"

namespace cwm::perception {
namespace {

// Calls visit(k) for each bit k that is set.
template <class Visit>
void ForEachBit(std::uint64_t bits, const Visit& visit) {
  for (; bits != 0; bits &= bits - 1) visit(static_cast<std::size_t>(std::countr_zero(bits)));
}

void Overlay(const RobotMask& robots, const DepthCamera& camera, std::uint8_t* classes) {
  if (robots.empty()) return;
  for (int v = std::max(0, robots.v_begin); v < std::min(camera.height, robots.v_end); ++v) {
    const std::size_t row = static_cast<std::size_t>(v) * camera.width;
    for (int u = std::max(0, robots.u_begin); u < std::min(camera.width, robots.u_end); ++u) {
      const std::uint8_t robot = robots.pixels[row + u];
      if (robot != 0) classes[row + u] = robot;
    }
  }
}

// The class of a depth that is outside of the gates.
class DeviationJudge {
 public:
  DeviationJudge(const KnownView& known, const DepthCamera& camera)
      : known_(known), width_(camera.width), rays_(camera, known.X_WC) {}

  PixelClass At(std::size_t i, float z) const {
    if (known_.reference != nullptr && known_.reference->Knows(i)) {
      return z < known_.reference->low_m()[i] ? PixelClass::kNearer : PixelClass::kFarther;
    }
    if (z < known_.gates->low_m()[i]) {
      return WasSeen(i, z) ? PixelClass::kConsistent : PixelClass::kNearer;
    }
    return z <= known_.gates->high_m()[i] ? PixelClass::kConsistent : PixelClass::kFarther;
  }

  // False for a pixel about which nothing is known yet.
  bool CountsForBlock(std::size_t i) const {
    return !known_.is_first || (*known_.expected_m)[i] != std::numeric_limits<float>::infinity();
  }

 private:
  bool WasSeen(std::size_t i, float z) const {
    if (known_.seen == nullptr) return false;
    const auto u = static_cast<int>(i % static_cast<std::size_t>(width_));
    const auto v = static_cast<int>(i / static_cast<std::size_t>(width_));
    return known_.seen->IsKnown(known_.X_WC.translation() + rays_.Point(u, v, z).cast<double>());
  }

  const KnownView& known_;
  const int width_;
  const PixelRays rays_;
};

// Counts pixels by body and class. Neighbours are mostly of one kind, so they are counted first.
class PixelTally {
 public:
  PixelTally(BodyPixels& by_body, PixelCounts& all) : by_body_(by_body), all_(all) {}

  void Add(BodyId body, PixelClass pixel, int count = 1) {
    const auto index = static_cast<std::size_t>(pixel);
    if (body != body_ || index != index_) {
      Flush();
      body_ = body;
      index_ = index;
    }
    count_ += count;
  }
  void Flush() {
    all_[index_] += count_;
    by_body_.of(body_)[index_] += count_;
    count_ = 0;
  }

 private:
  BodyPixels& by_body_;
  PixelCounts& all_;
  BodyId body_ = kNoBody;
  std::size_t index_ = 0;
  std::int64_t count_ = 0;
};

void Increment(std::uint8_t& count) { ++count; }  // a block has at most 64 pixels

void FindHotBlocks(const std::size_t block_count, BlockCounts& blocks, FrameClasses& classes) {
  for (std::size_t i = 0; i < block_count; ++i) {
    const int count = std::max(blocks.nearer[i], blocks.farther[i]);
    const bool is_over = count >= kHotPixels;
    const bool stays = blocks.was_over[i] != 0 && count >= kHotPixels / 2;
    blocks.was_over[i] = static_cast<std::uint8_t>(is_over);
    classes.hot_blocks[i] = static_cast<std::uint8_t>(is_over || stays);
  }
}

}  // namespace

BodyPixels::BodyPixels() : place_(static_cast<std::size_t>(kNoBody) + 1, 0), counts_(1) {}

PixelCounts& BodyPixels::of(BodyId id) {
  std::uint32_t& place = place_[id];
  if (place == 0) {
    place = static_cast<std::uint32_t>(counts_.size());
    counted_.push_back(id);
    counts_.emplace_back();
  }
  return counts_[place];
}

void BodyPixels::Clear() {
  for (const BodyId id : counted_) place_[id] = 0;
  counted_.clear();
  counts_.resize(1);
}

void CompareFrame(const DepthImage& image, const DepthCamera& camera, const KnownView& known,
                  const RobotMask& robots, FrameClasses& classes, BodyPixels& by_body,
                  BlockCounts& blocks) {
  classes.width = camera.width;
  classes.height = camera.height;
  classes.block_columns = (camera.width + kBlock_px - 1) / kBlock_px;
  classes.block_rows = (camera.height + kBlock_px - 1) / kBlock_px;
  const std::size_t pixel_count = camera.pixel_count();
  const auto block_count = static_cast<std::size_t>(classes.block_columns) * classes.block_rows;
  classes.pixels.resize(pixel_count);
  classes.hot_blocks.resize(block_count);
  blocks.nearer.assign(block_count, 0);
  blocks.farther.assign(block_count, 0);
  blocks.was_over.resize(block_count, 0);

  const float* const depth_m = image.depth_m.data();
  const bool has_reference = known.reference != nullptr;
  const auto& low_m = has_reference ? known.reference->low_m() : known.gates->low_m();
  const auto& high_m = has_reference ? known.reference->high_m() : known.gates->high_m();
  auto* const bytes = reinterpret_cast<std::uint8_t*>(classes.pixels.data());
  CompareWithGates(depth_m, low_m.data(), high_m.data(), pixel_count, bytes);
  Overlay(robots, camera, bytes);
  blocks.deviations.resize((pixel_count + kPixelsPerWord - 1) / kPixelsPerWord);
  FindDeviations(bytes, known.body->data(), pixel_count, blocks.deviations.data());

  const DeviationJudge judge(known, camera);
  const std::vector<BodyId>& bodies = *known.body;
  PixelCounts counts = {};
  PixelTally tally(by_body, counts);
  const auto width = static_cast<std::size_t>(camera.width);
  std::size_t row = 0;  // the first pixel of the row
  std::size_t block_row = 0;
  const auto judge_pixel = [&](std::size_t i) {
    PixelClass& pixel = classes.pixels[i];
    if (bytes[i] == 0) {
      const float z = depth_m[i];
      const bool is_return = z >= camera.least_range_m && z <= camera.greatest_range_m;
      pixel = is_return ? judge.At(i, z) : PixelClass::kMissing;
      if (pixel == PixelClass::kConsistent) return;
      if (is_return && judge.CountsForBlock(i)) {
        while (i >= row + width) {
          row += width;
          block_row = row / width / kBlock_px * classes.block_columns;
        }
        const std::size_t block = block_row + (i - row) / kBlock_px;
        Increment(pixel == PixelClass::kNearer ? blocks.nearer[block] : blocks.farther[block]);
      }
    }
    tally.Add(bodies[i], pixel);
  };
  for (std::size_t first = 0; first < pixel_count; first += kPixelsPerWord) {
    const DeviatingPixels& word = blocks.deviations[first / kPixelsPerWord];
    if (word.is_one_body) {
      tally.Add(bodies[first], PixelClass::kMissing, word.missing_count);
    } else {
      ForEachBit(word.missing,
                 [&](std::size_t k) { tally.Add(bodies[first + k], PixelClass::kMissing); });
    }
    ForEachBit(word.others, [&](std::size_t k) { judge_pixel(first + k); });
  }
  tally.Flush();
  counts[static_cast<std::size_t>(PixelClass::kConsistent)] =
      static_cast<std::int64_t>(pixel_count) -
      std::accumulate(counts.begin(), counts.end(), std::int64_t{0});
  classes.counts = counts;
  FindHotBlocks(block_count, blocks, classes);
}

}  // namespace cwm::perception
