// Follows a world while somebody else changes it: keeps the names of its objects.
#include <cwm/client.h>

#include <cstdio>
#include <set>
#include <string>
#include <thread>
#include <variant>

// Somebody else.
void Change(const cwm::World& world) {
  world.Move("ball", Eigen::Isometry3d(Eigen::Translation3d(0.1, 0, 0.5)));
  world.Put("cup", cwm::Cylinder{0.04, 0.1});
  world.Remove("ball");
}

int main() try {
  const cwm::World world = cwm::Connect({.world = "watch_world"});
  world.Put("ball", cwm::Sphere{0.05});
  std::set<std::string> names;
  std::thread somebody;
  cwm::Watcher watch = world.Watch();
  while (const auto event = watch.Next()) {
    if (const auto* snapshot = std::get_if<cwm::Snapshot>(&*event)) {
      // The first event; again if the server lost its memory.
      names.clear();
      for (const cwm::Object& object : snapshot->objects) names.insert(object.name);
      if (!somebody.joinable()) somebody = std::thread(Change, world);
    } else if (const auto* changes = std::get_if<cwm::Changes>(&*event)) {
      for (const cwm::Event& change : changes->events) {
        if (const auto* put = std::get_if<cwm::ObjectPut>(&change)) names.insert(put->object.name);
        if (const auto* gone = std::get_if<cwm::ObjectRemoved>(&change)) names.erase(gone->name);
      }
      std::printf("revision %lld:", static_cast<long long>(changes->revision));
      for (const std::string& name : names) std::printf(" %s", name.c_str());
      std::printf("\n");
      if (!names.contains("ball")) watch.Close();
    }
  }
  somebody.join();
} catch (const cwm::Error& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
