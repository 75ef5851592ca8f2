// Queries the distance of a ball at the origin from the world "default", with messages and stubs.
#include <cwm/rpc.h>

#include <cstdio>

int main(int argc, char** argv) {
  if (argc != 2) return 1;
  const cwm::client::Connection connection({.address = argv[1], .deadline = {}});
  cwm::v1::GetDistancesRequest request;
  auto& shapes = *request.mutable_subject()->mutable_shapes();
  shapes.add_shapes()->mutable_sphere()->set_radius_m(0.1);
  shapes.mutable_x_world_body()->set_scalar(cwm::v1::SCALAR_F64);
  shapes.mutable_x_world_body()->set_data(cwm::client::RowBytes<7>({{0, 0, 0, 0, 0, 0, 1}}));
  request.mutable_options()->set_result_form(cwm::v1::RESULT_FORM_ROWS);
  const auto answer =
      connection.Call(&cwm::v1::QueryService::Stub::GetDistances, connection.queries(), request);
  if (!answer.ok()) {
    std::fprintf(stderr, "%s\n", answer.status().ToString().c_str());
    return 1;
  }
  const auto& nearest = answer->rows(0).answers(0);
  std::printf("%s %.3f\n", nearest.object().c_str(), nearest.distance_m());
}
