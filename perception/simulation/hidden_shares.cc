#include "perception/simulation/hidden_shares.h"

#include "perception/simulation/range_image.h"

namespace cwm::perception {

std::vector<double> HiddenShares(const SimulatedScene& scene, const PinholeCamera& camera) {
  const RangeImage together = Render(scene, camera);
  std::vector<double> shares;
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    const RangeImage alone = Render({.objects = {scene.objects[i]}}, camera);
    std::size_t seen_alone = 0;
    std::size_t hidden = 0;
    for (std::size_t pixel = 0; pixel < alone.pixels.size(); ++pixel) {
      if (!alone.pixels[pixel].seen()) continue;
      ++seen_alone;
      hidden += together.pixels[pixel].object != static_cast<std::int32_t>(i);
    }
    shares.push_back(
        seen_alone == 0 ? 1 : static_cast<double>(hidden) / static_cast<double>(seen_alone));
  }
  return shares;
}

}  // namespace cwm::perception
