#include "server/core/live/body_table.h"

#include <algorithm>
#include <utility>

namespace cwm::server {
namespace {

using collision::ObjectKind;
using collision::WorldObject;
using perception::BodyId;
using perception::kNoBody;
using perception::KnownBody;

KnownBody::Kind BodyKindOf(const WorldObject& object) {
  if (object.attachment != nullptr) return KnownBody::Kind::kCarried;
  if (object.kind == ObjectKind::kMover) return KnownBody::Kind::kMover;
  if (object.owner == collision::Owner::kUser) return KnownBody::Kind::kUser;
  switch (object.kind) {
    case ObjectKind::kSupport:
      return KnownBody::Kind::kSupport;
    case ObjectKind::kResidual:
      return KnownBody::Kind::kResidual;
    default:
      return KnownBody::Kind::kObject;
  }
}

}  // namespace

collision::WorldObjectPtr BodyTable::Find(BodyId id) const {
  const auto found = std::ranges::find(bodies, id, &KnownBody::id);
  if (found == bodies.end()) return nullptr;
  return objects[static_cast<std::size_t>(found - bodies.begin())];
}

std::shared_ptr<const BodyTable> BodyNumbers::TableOf(const SnapshotPtr& snapshot) {
  const std::lock_guard lock(mutex_);
  if (table_ != nullptr && table_->snapshot == snapshot) return table_;
  auto table = std::make_shared<BodyTable>();
  table->snapshot = snapshot;
  for (auto& [name, known] : known_) known.is_present = false;
  for (const collision::WorldObjectPtr& object : snapshot->objects()) {
    if (object->kind == ObjectKind::kUnseen || object->geometry == nullptr) continue;
    Known& known = known_[object->name];
    if (known.id == kNoBody || known.create_revision != object->create_revision) {
      if (known.id != kNoBody) is_taken_[known.id] = false;
      known = {.create_revision = object->create_revision, .id = NextFree()};
    }
    known.is_present = true;
    if (known.id == kNoBody) continue;
    table->bodies.push_back({.id = known.id,
                             .kind = BodyKindOf(*object),
                             .name = object->name,
                             .X_WB = object->X_WO,
                             .model = object->geometry->model});
    table->objects.push_back(object);
  }
  std::erase_if(known_, [this](const auto& each) {
    const Known& known = each.second;
    if (known.is_present) return false;
    if (known.id != kNoBody) is_taken_[known.id] = false;
    return true;
  });
  table_ = std::move(table);
  return table_;
}

BodyId BodyNumbers::NextFree() {
  for (std::size_t tries = 0; tries < is_taken_.size(); ++tries) {
    last_ = static_cast<BodyId>((last_ + 1) % is_taken_.size());
    if (is_taken_[last_]) continue;
    is_taken_[last_] = true;
    return last_;
  }
  return kNoBody;
}

}  // namespace cwm::server
