#include "clients/formats/cloud_file.h"

#include <algorithm>
#include <cassert>
#include <cstring>

namespace cwm::formats {
namespace {

// A copy of the cloud with other fields: fields that both have are copied, the rest is zero.
CloudFile WithFields(const CloudFile& cloud, std::vector<CloudField> fields) {
  CloudFile copy{.width = cloud.width, .height = cloud.height, .viewpoint = cloud.viewpoint};
  copy.point_step = AssignOffsets(fields);
  copy.fields = std::move(fields);
  const auto points = static_cast<std::size_t>(cloud.size());
  copy.bytes.resize(points * copy.point_step);
  for (const CloudField& to : copy.fields) {
    const CloudField* from = cloud.Find(to.name);
    if (from == nullptr || from->type != to.type || from->count != to.count) continue;
    for (std::size_t p = 0; p < points; ++p) {
      std::memcpy(&copy.bytes[p * copy.point_step + to.offset],
                  &cloud.bytes[p * cloud.point_step + from->offset], to.size());
    }
  }
  return copy;
}

}  // namespace

const CloudField* CloudFile::Find(std::string_view name) const {
  const auto found = std::find_if(fields.begin(), fields.end(),
                                  [&](const CloudField& field) { return field.name == name; });
  return found == fields.end() ? nullptr : &*found;
}

std::size_t AssignOffsets(std::vector<CloudField>& fields) {
  std::size_t offset = 0;
  for (CloudField& field : fields) {
    field.offset = offset;
    offset += field.size();
  }
  return offset;
}

CloudFile SelectFields(const CloudFile& cloud, const std::vector<std::string>& names) {
  std::vector<CloudField> fields;
  for (const std::string& name : names) {
    const CloudField* field = cloud.Find(name);
    assert(field != nullptr);
    fields.push_back(*field);
  }
  return WithFields(cloud, std::move(fields));
}

CloudFile WithLabels(const CloudFile& cloud, const std::vector<std::uint32_t>& labels) {
  assert(labels.size() == static_cast<std::size_t>(cloud.size()));
  const CloudField label{.name = "label", .type = Scalar::kU32};
  std::vector<CloudField> fields = cloud.fields;
  if (const CloudField* old = cloud.Find("label"); old != nullptr) {
    fields[static_cast<std::size_t>(old - cloud.fields.data())] = label;
  } else {
    fields.push_back(label);
  }
  CloudFile labelled = WithFields(cloud, std::move(fields));
  const std::size_t offset = labelled.Find("label")->offset;
  for (std::size_t p = 0; p < labels.size(); ++p) {
    std::memcpy(&labelled.bytes[p * labelled.point_step + offset], &labels[p], sizeof(labels[p]));
  }
  return labelled;
}

}  // namespace cwm::formats
