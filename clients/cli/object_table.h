// Objects as tables.
#pragma once

#include <google/protobuf/repeated_ptr_field.h>

#include <cstdint>
#include <iosfwd>
#include <string>
#include <vector>

#include "clients/cli/table.h"
#include "cwm/v1/world.pb.h"

namespace cwm::cli {

// "cylinder r 33.1 mm, l 101.0 mm"
std::string ShapeText(const cwm::v1::ShapePart& part);

// A label beside an object, as the labelled cloud has it; -1: no column of labels.
struct LabelledObject {
  const cwm::v1::Object* object = nullptr;
  int label = -1;
};

// One line for each part: name, kind, shape, quality of the fit, size, support, position, and the
// coefficients under it.
void PrintObjects(const std::vector<LabelledObject>& objects, TableStyle style, std::ostream& out);
void PrintObjects(const google::protobuf::RepeatedPtrField<cwm::v1::Object>& objects,
                  TableStyle style, std::ostream& out);

// Everything about one object.
void PrintObjectDetails(const cwm::v1::Object& object, TableStyle style, std::ostream& out);

}  // namespace cwm::cli
