// CGAL's Efficient_RANSAC on the objects of one scene: the baseline of the model search, as a
// program of its own because CGAL's shape detection is GPL and no library of the server links it. One
// thread.
//   cwm-bench-cgal OBJECTS EPSILON_M NORMAL_COSINE LEAST_POINTS PROBABILITY CLUSTER_GAP_M
// OBJECTS is a file: per object a uint32 count, then as many rows of six floats, point and unit
// normal. Prints the total milliseconds, the points, the points on a shape, and the number of
// shapes.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Point_with_normal_3.h>
#include <CGAL/Shape_detection/Efficient_RANSAC.h>
#include <CGAL/property_map.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <utility>
#include <vector>

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using PointWithNormal = std::pair<Kernel::Point_3, Kernel::Vector_3>;
using Points = std::vector<PointWithNormal>;
using Traits = CGAL::Shape_detection::Efficient_RANSAC_traits<
    Kernel, Points, CGAL::First_of_pair_property_map<PointWithNormal>,
    CGAL::Second_of_pair_property_map<PointWithNormal>>;
using Search = CGAL::Shape_detection::Efficient_RANSAC<Traits>;

std::vector<Points> ReadObjects(const char* path) {
  std::ifstream file(path, std::ios::binary);
  std::vector<Points> objects;
  std::uint32_t count = 0;
  while (file.read(reinterpret_cast<char*>(&count), sizeof(count))) {
    std::vector<std::array<float, 6>> rows(count);
    if (!file.read(reinterpret_cast<char*>(rows.data()),
                   static_cast<std::streamsize>(count * sizeof(rows[0])))) {
      break;
    }
    Points& points = objects.emplace_back();
    for (const auto& r : rows) {
      points.emplace_back(Kernel::Point_3(r[0], r[1], r[2]), Kernel::Vector_3(r[3], r[4], r[5]));
    }
  }
  return objects;
}

struct Sum {
  double ms = 0;
  std::size_t points = 0, explained = 0, shapes = 0;
};

void Detect(Points& points, const Search::Parameters& parameters, Sum& sum) {
  const auto start = std::chrono::steady_clock::now();
  Search search;
  search.set_input(points);
  search.add_shape_factory<CGAL::Shape_detection::Plane<Traits>>();
  search.add_shape_factory<CGAL::Shape_detection::Cylinder<Traits>>();
  search.add_shape_factory<CGAL::Shape_detection::Sphere<Traits>>();
  search.add_shape_factory<CGAL::Shape_detection::Cone<Traits>>();
  search.detect(parameters);
  sum.ms +=
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  sum.points += points.size();
  sum.explained += points.size() - search.number_of_unassigned_points();
  sum.shapes += search.shapes().size();
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 7) {
    std::fprintf(stderr, "cwm-bench-cgal: six arguments, see the source\n");
    return 2;
  }
  CGAL::get_default_random() = CGAL::Random(1);
  Search::Parameters parameters;
  parameters.epsilon = std::atof(argv[2]);
  parameters.normal_threshold = std::atof(argv[3]);
  parameters.min_points = static_cast<std::size_t>(std::atoi(argv[4]));
  parameters.probability = std::atof(argv[5]);
  parameters.cluster_epsilon = std::atof(argv[6]);
  Sum sum;
  for (Points& points : ReadObjects(argv[1])) Detect(points, parameters, sum);
  std::printf("%.3f %zu %zu %zu\n", sum.ms, sum.points, sum.explained, sum.shapes);
  return 0;
}
