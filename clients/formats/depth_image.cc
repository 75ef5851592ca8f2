#include "clients/formats/depth_image.h"

#include <png.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <csetjmp>
#include <cstring>
#include <limits>
#include <vector>

#include "absl/strings/str_cat.h"
#include "clients/formats/format_error.h"
#include "clients/formats/npy.h"
#include "clients/formats/npy_header.h"

namespace cwm::formats {
namespace {

constexpr std::string_view kPngMagic = "\x89PNG\r\n\x1a\n";
// chosen: more pixels than a camera has, few enough for memory.
constexpr std::uint64_t kMaxPixels = 1 << 26;

// The unit of integers, as most cameras and programs write them, and of floats.
constexpr double kMillimetre = 0.001, kMetre = 1;

struct PngSource {
  std::string_view left;
  std::string error;
};

void ReadPngBytes(png_structp png, png_bytep out, png_size_t count) {
  auto& source = *static_cast<PngSource*>(png_get_io_ptr(png));
  if (source.left.size() < count) png_error(png, "the file ends early");
  std::memcpy(out, source.left.data(), count);
  source.left.remove_prefix(count);
}

[[noreturn]] void KeepPngError(png_structp png, png_const_charp message) {
  static_cast<PngSource*>(png_get_error_ptr(png))->error = message;
  png_longjmp(png, 1);
}

void IgnorePngWarning(png_structp /*png*/, png_const_charp /*message*/) {}

struct PngHeader {
  png_uint_32 width = 0, height = 0;
  int bit_depth = 0, color_type = 0;
};

// The functions below have no objects with destructors, since libpng leaves them by longjmp.
bool ReadPngHeader(png_structp png, png_infop info, PngHeader* header) {
  if (setjmp(png_jmpbuf(png))) return false;
  png_read_info(png, info);
  png_get_IHDR(png, info, &header->width, &header->height, &header->bit_depth, &header->color_type,
               nullptr, nullptr, nullptr);
  return true;
}

bool ReadPngRows(png_structp png, png_bytepp rows) {
  if (setjmp(png_jmpbuf(png))) return false;
  if (std::endian::native == std::endian::little) png_set_swap(png);
  png_read_image(png, rows);
  return true;
}

class PngReader {
 public:
  PngReader(std::string_view bytes, const std::string& file) : file_(file), source_{bytes, ""} {
    png_ = png_create_read_struct(PNG_LIBPNG_VER_STRING, &source_, KeepPngError, IgnorePngWarning);
    if (png_ != nullptr) info_ = png_create_info_struct(png_);
  }
  ~PngReader() { png_destroy_read_struct(&png_, &info_, nullptr); }
  PngReader(const PngReader&) = delete;
  PngReader& operator=(const PngReader&) = delete;

  absl::StatusOr<DepthImage> Read() {
    if (png_ == nullptr || info_ == nullptr) {
      return absl::ResourceExhaustedError(absl::StrCat(file_, ": no memory to read a PNG"));
    }
    png_set_read_fn(png_, &source_, ReadPngBytes);
    PngHeader header;
    if (!ReadPngHeader(png_, info_, &header)) return Damaged();
    if (header.bit_depth != 16 || header.color_type != PNG_COLOR_TYPE_GRAY) {
      return FileError(
          file_, {"the image",
                  absl::StrCat(header.bit_depth, " bits a channel, ",
                               header.color_type == PNG_COLOR_TYPE_GRAY ? "grey" : "in colour"),
                  "must be a depth image: one channel of 16 bits"});
    }
    const std::uint64_t pixels = std::uint64_t{header.width} * header.height;
    if (pixels > kMaxPixels) {
      return FileError(file_, {"the image", absl::StrCat(header.width, " x ", header.height),
                               absl::StrCat("must have at most ", kMaxPixels, " pixels")});
    }
    DepthImage image{.width = header.width, .height = header.height};
    image.bytes.resize(pixels * sizeof(std::uint16_t));
    std::vector<png_bytep> rows(header.height);
    for (std::size_t v = 0; v < rows.size(); ++v) {
      rows[v] = reinterpret_cast<png_bytep>(image.bytes.data()) +
                v * header.width * sizeof(std::uint16_t);
    }
    if (!ReadPngRows(png_, rows.data())) return Damaged();
    return image;
  }

 private:
  absl::Status Damaged() const {
    return FileError(file_, {"the PNG", "", absl::StrCat("is damaged: ", source_.error)});
  }

  const std::string& file_;
  PngSource source_;
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
};

// True for the shapes of images; a list of points is narrower.
bool IsImageShape(const NpyHeader& header) {
  const std::vector<std::int64_t>& shape = header.shape;
  const bool flat = shape.size() == 2 || (shape.size() == 3 && shape[2] == 1);
  return header.members.empty() && flat && shape[1] > kMaxNpyColumns;
}

absl::StatusOr<DepthImage> ReadNpyImage(std::string_view bytes, const std::string& file) {
  const auto header = ParseNpyHeader(bytes, file);
  if (!header.ok()) return header.status();
  const auto type = NumberType(header->type);
  if (!type) return FileError(file, {"descr", header->type, "must be an integer or a float"});
  const auto height = static_cast<std::uint64_t>(header->shape[0]);
  const auto width = static_cast<std::uint64_t>(header->shape[1]);
  if (height == 0 || height > kMaxPixels / width) {
    return FileError(file, {"shape", absl::StrCat("(", height, ", ", width, ")"),
                            absl::StrCat("must have 1 to ", kMaxPixels, " pixels")});
  }
  const std::size_t size = SizeOf(type->type);
  std::string data(bytes.substr(header->data_begin));
  if (data.size() != height * width * size) {
    return FileError(file, {"shape", absl::StrCat("(", height, ", ", width, ")"),
                            absl::StrCat("must be what the data holds, ", data.size(), " bytes")});
  }
  const bool is_float = type->type == Scalar::kF32 || type->type == Scalar::kF64;
  const bool is_short = type->type == Scalar::kU16 || type->type == Scalar::kU8;
  DepthImage image{.width = header->shape[1],
                   .height = header->shape[0],
                   .type = is_short ? Scalar::kU16 : Scalar::kF32,
                   .unit_m = is_float ? kMetre : kMillimetre};
  image.bytes.resize(height * width * SizeOf(image.type));
  for (std::size_t i = 0; i < height * width; ++i) {
    char* number = data.data() + i * size;
    if (type->big_endian) std::reverse(number, number + size);
    const std::size_t place =
        header->fortran_order ? i % height * width + i / height : i;  // columns first
    const double depth = ToDouble(number, type->type);
    char* out = image.bytes.data() + place * SizeOf(image.type);
    if (is_short) {
      const auto units = static_cast<std::uint16_t>(depth);
      std::memcpy(out, &units, sizeof(units));
    } else {
      const auto value = static_cast<float>(depth);
      std::memcpy(out, &value, sizeof(value));
    }
  }
  return image;
}

// NaN where there is no return.
double DepthAt(const DepthImage& image, std::size_t pixel) {
  constexpr double kNoReturn = std::numeric_limits<double>::quiet_NaN();
  constexpr double kSaturated = 65'535;  // as Kinects and their drivers mark it
  const double depth = ToDouble(image.bytes.data() + pixel * SizeOf(image.type), image.type);
  if (!std::isfinite(depth) || depth <= 0) return kNoReturn;
  return image.type == Scalar::kU16 && depth == kSaturated ? kNoReturn : depth;
}

}  // namespace

bool IsDepthImage(std::string_view bytes) {
  if (bytes.starts_with(kPngMagic)) return true;
  if (!bytes.starts_with(kNpyMagic)) return false;
  const auto header = ParseNpyHeader(bytes, "");
  return header.ok() && IsImageShape(*header);
}

absl::StatusOr<DepthImage> ReadDepthImage(std::string_view bytes, const std::string& file) {
  return bytes.starts_with(kPngMagic) ? PngReader(bytes, file).Read() : ReadNpyImage(bytes, file);
}

absl::StatusOr<CloudFile> ParseDepthImage(std::string_view bytes, const std::string& file,
                                          const DepthCamera& camera, std::optional<double> unit_m) {
  const auto image = ReadDepthImage(bytes, file);
  if (!image.ok()) return image.status();
  const double scale = unit_m ? *unit_m : camera.unit_m.value_or(image->unit_m);
  CloudFile cloud{.fields = {{.name = "x"}, {.name = "y"}, {.name = "z"}},
                  .width = image->width,
                  .height = image->height};
  cloud.point_step = AssignOffsets(cloud.fields);
  cloud.bytes.resize(static_cast<std::size_t>(cloud.size()) * cloud.point_step);
  char* out = cloud.bytes.data();
  for (std::int64_t v = 0; v < image->height; ++v) {
    for (std::int64_t u = 0; u < image->width; ++u, out += cloud.point_step) {
      const double z = DepthAt(*image, static_cast<std::size_t>(v * image->width + u)) * scale;
      const float point[] = {
          static_cast<float>((static_cast<double>(u) - camera.cx_px) / camera.fx_px * z),
          static_cast<float>((static_cast<double>(v) - camera.cy_px) / camera.fy_px * z),
          static_cast<float>(z)};
      std::memcpy(out, point, sizeof(point));
    }
  }
  return cloud;
}

}  // namespace cwm::formats
