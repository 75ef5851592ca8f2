#include "tests/fault/fingerprint.h"

#include <chrono>
#include <utility>

#include "clients/cpp/geometry_transfer.h"
#include "clients/cpp/world_export.h"
#include "proto/transfer/sha256.h"

namespace cwm::fault {
namespace {

class Asker {
 public:
  explicit Asker(const client::Connection& connection) : connection_(connection) {}

  Fingerprint Run() {
    const auto worlds = connection_.Call(&v1::WorldService::Stub::ListWorlds, connection_.worlds(),
                                         v1::ListWorldsRequest());
    if (!worlds.ok()) {
      Refuse("worlds", worlds.status());
      return std::move(answers_);
    }
    std::string names;
    for (const v1::World& world : worlds->worlds()) {
      names +=
          world.name() + " " + world.world_uid() + " " + std::to_string(world.revision()) + "; ";
      AskWorld(world);
    }
    answers_["worlds"] = names;
    return std::move(answers_);
  }

 private:
  void Refuse(const std::string& what, const absl::Status& status) {
    const std::string reason = client::DetailsOf(status).reason;
    answers_[what] = kRefused + (reason.empty() ? status.ToString() : reason);
  }

  void AskWorld(const v1::World& world) {
    v1::ListObjectsRequest objects;
    objects.set_world(world.name());
    objects.set_view(v1::OBJECT_VIEW_FULL);
    objects.set_page_size(10'000);
    const auto listed =
        connection_.Call(&v1::WorldService::Stub::ListObjects, connection_.worlds(), objects);
    if (listed.ok()) {
      Sha256 digest;
      for (const v1::Object& object : listed->objects()) {
        Add(object, digest);
        AskMeshes(world.name(), object);
      }
      answers_[world.name() + " objects"] = digest.Hex();
    } else {
      Refuse(world.name() + " objects", listed.status());
    }
    AskRobots(world.name());
    AskRules(world.name());
    AskFile(world.name());
    Watch(world);
  }

  template <class Message>
  static void Add(const Message& message, Sha256& digest) {
    const std::string bytes = message.SerializeAsString();
    digest.Add(bytes.data(), bytes.size());
  }

  void AskMeshes(const std::string& world, const v1::Object& object) {
    for (const v1::ShapePart& part : object.shapes()) {
      if (!part.has_mesh()) continue;
      const std::string what = world + " mesh of " + object.name();
      const auto blob = client::ReadGeometry(connection_, part.mesh().hash());
      if (blob.ok()) {
        answers_[what] = Sha256Hex(blob->bytes);
      } else {
        Refuse(what, blob.status());
      }
    }
  }

  void AskRobots(const std::string& world) {
    v1::ListRobotsRequest request;
    request.set_world(world);
    const auto reply =
        connection_.Call(&v1::RobotService::Stub::ListRobots, connection_.robots(), request);
    if (!reply.ok()) return Refuse(world + " robots", reply.status());
    Sha256 digest;
    for (const v1::Robot& robot : reply->robots()) Add(robot, digest);
    answers_[world + " robots"] = digest.Hex();
  }

  void AskRules(const std::string& world) {
    v1::GetWorldRequest request;
    request.set_world(world);
    const auto reply =
        connection_.Call(&v1::WorldService::Stub::GetWorld, connection_.worlds(), request);
    if (!reply.ok()) return Refuse(world + " rules", reply.status());
    Sha256 digest;
    for (const v1::PairRule& rule : reply->pair_rules()) Add(rule, digest);
    answers_[world + " rules"] = digest.Hex();
  }

  void AskFile(const std::string& world) {
    v1::ExportWorldRequest request;
    request.set_world(world);
    request.set_format(v1::EXPORT_FORMAT_GLB);
    const auto file = client::ExportWorld(connection_, request);
    if (!file.ok()) return Refuse(world + " glb", file.status());
    answers_[world + " glb"] = Sha256Hex(file->bytes);
  }

  // All events since revision 0.
  void Watch(const v1::World& world) {
    v1::WatchWorldRequest request;
    request.set_world(world.name());
    request.set_view(v1::OBJECT_VIEW_FULL);
    request.set_from_revision(0);
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(10));
    const auto reader = connection_.worlds().WatchWorld(&context, request);
    v1::WatchWorldResponse response;
    Sha256 digest;
    std::int64_t reached = 0;
    while (reached < world.revision() && reader->Read(&response)) {
      if (response.has_events()) Add(response, digest);
      if (!response.events().more()) reached = response.revision();
    }
    context.TryCancel();
    const grpc::Status status = reader->Finish();
    const std::string what = world.name() + " watch";
    if (reached < world.revision()) return Refuse(what, client::StatusFromGrpc(status));
    answers_[what] = digest.Hex();
  }

  const client::Connection& connection_;
  Fingerprint answers_;
};

}  // namespace

Fingerprint FingerprintOf(const client::Connection& connection) { return Asker(connection).Run(); }

}  // namespace cwm::fault
