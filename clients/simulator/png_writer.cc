#include "clients/simulator/png_writer.h"

#include <png.h>

#include <bit>
#include <csetjmp>

namespace cwm::simulator {
namespace {

// chosen: a frame of 640 x 480 in a third of the time of the default level, a tenth larger.
constexpr int kCompression = 1;

void AppendBytes(png_structp png, png_bytep bytes, png_size_t count) {
  static_cast<std::string*>(png_get_io_ptr(png))
      ->append(reinterpret_cast<const char*>(bytes), count);
}

void Flush(png_structp /*png*/) {}

// Has no objects with destructors, since libpng leaves it by longjmp.
bool WriteImage(png_structp png, png_infop info, std::string* out, int width, int height,
                const std::uint16_t* values) {
  if (setjmp(png_jmpbuf(png))) return false;
  png_set_write_fn(png, out, AppendBytes, Flush);
  png_set_compression_level(png, kCompression);
  png_set_filter(png, PNG_FILTER_TYPE_BASE, PNG_FILTER_SUB);
  png_set_IHDR(png, info, static_cast<png_uint_32>(width), static_cast<png_uint_32>(height), 16,
               PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  png_write_info(png, info);
  if (std::endian::native == std::endian::little) png_set_swap(png);
  for (int v = 0; v < height; ++v) {
    png_write_row(png, reinterpret_cast<png_const_bytep>(values + std::size_t(v) * width));
  }
  png_write_end(png, info);
  return true;
}

}  // namespace

absl::StatusOr<std::string> FormatPng16(int width, int height,
                                        const std::vector<std::uint16_t>& values) {
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png == nullptr ? nullptr : png_create_info_struct(png);
  std::string bytes;
  const bool good = info != nullptr && WriteImage(png, info, &bytes, width, height, values.data());
  png_destroy_write_struct(&png, &info);
  if (!good) return absl::ResourceExhaustedError("no memory to write a PNG");
  return bytes;
}

}  // namespace cwm::simulator
