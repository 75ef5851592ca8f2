#include "clients/formats/depth_image.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <png.h>

#include <cmath>
#include <cstring>

namespace cwm::formats {
namespace {

using ::testing::HasSubstr;

const DepthCamera kCamera{.fx_px = 100, .fy_px = 50, .cx_px = 1, .cy_px = 0};

// A PNG by libpng's own writer.
std::string Png(int width, int height, int bit_depth, const std::vector<std::uint16_t>& values) {
  std::string bytes;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_set_write_fn(
      png, &bytes,
      [](png_structp to, png_bytep data, png_size_t size) {
        static_cast<std::string*>(png_get_io_ptr(to))
            ->append(reinterpret_cast<const char*>(data), size);
      },
      nullptr);
  png_set_IHDR(png, info, static_cast<png_uint_32>(width), static_cast<png_uint_32>(height),
               bit_depth, PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  png_write_info(png, info);
  for (int v = 0; v < height; ++v) {
    std::vector<png_byte> row;
    for (int u = 0; u < width; ++u) {
      const std::uint16_t value = values[static_cast<std::size_t>(v * width + u)];
      if (bit_depth == 16) row.push_back(static_cast<png_byte>(value >> 8));
      row.push_back(static_cast<png_byte>(value & 0xff));
    }
    png_write_row(png, row.data());
  }
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  return bytes;
}

template <class T>
std::string Npy(const std::string& descr, const std::string& shape, const std::vector<T>& values,
                const std::string& fortran = "False") {
  const std::string dictionary =
      "{'descr': '" + descr + "', 'fortran_order': " + fortran + ", 'shape': " + shape + ", }\n";
  std::string bytes("\x93NUMPY\x01\x00", 8);
  bytes.push_back(static_cast<char>(dictionary.size() & 0xff));
  bytes.push_back(static_cast<char>(dictionary.size() >> 8));
  bytes += dictionary;
  bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
  return bytes;
}

std::array<float, 3> PointAt(const CloudFile& cloud, std::size_t i) {
  std::array<float, 3> p;
  std::memcpy(p.data(), cloud.bytes.data() + i * cloud.point_step, sizeof(p));
  return p;
}

TEST(DepthImage, PixelsOfAPngBecomePointsOfTheOpticalFrame) {
  const std::string png = Png(3, 2, 16, {1000, 0, 2000, 65535, 500, 1});
  ASSERT_TRUE(IsDepthImage(png));
  const auto cloud = ParseDepthImage(png, "depth.png", kCamera);
  ASSERT_TRUE(cloud.ok()) << cloud.status();
  EXPECT_EQ(cloud->width, 3);
  EXPECT_EQ(cloud->height, 2);
  // x = (0 - 1) 1 / 100 and y = 0.
  EXPECT_THAT(PointAt(*cloud, 0), ::testing::Pointwise(::testing::FloatEq(), {-0.01F, 0.F, 1.F}));
  EXPECT_TRUE(std::isnan(PointAt(*cloud, 1)[2])) << "0 is no return";
  // x = (2 - 1) 2 / 100.
  EXPECT_THAT(PointAt(*cloud, 2), ::testing::Pointwise(::testing::FloatEq(), {0.02F, 0.F, 2.F}));
  // y = (1 - 0) 0.5 / 50.
  EXPECT_THAT(PointAt(*cloud, 4), ::testing::Pointwise(::testing::FloatEq(), {0.F, 0.01F, 0.5F}));
  EXPECT_TRUE(std::isnan(PointAt(*cloud, 3)[2])) << "65535 is no return";
}

TEST(DepthImage, UnitsAreThoseOfTheTypeOfTheCameraOrOfTheCaller) {
  const std::string png = Png(1, 1, 16, {1000});
  const auto depth_m = [](const absl::StatusOr<CloudFile>& cloud) {
    return cloud.ok() ? PointAt(*cloud, 0)[2] : -1;
  };
  DepthCamera camera = kCamera;
  EXPECT_FLOAT_EQ(depth_m(ParseDepthImage(png, "a.png", camera)), 1);
  camera.unit_m = 0.0001;
  EXPECT_FLOAT_EQ(depth_m(ParseDepthImage(png, "a.png", camera)), 0.1F);
  EXPECT_FLOAT_EQ(depth_m(ParseDepthImage(png, "a.png", camera, 0.01)), 10);
}

TEST(DepthImage, ArraysWiderThanListsOfPointsAreImages) {
  std::vector<float> depths(17 * 2, 1.5F);
  depths[16] = 2;
  const std::string image = Npy("<f4", "(2, 17)", depths);
  ASSERT_TRUE(IsDepthImage(image));
  const auto cloud = ParseDepthImage(image, "a.npy", kCamera);
  ASSERT_TRUE(cloud.ok()) << cloud.status();
  EXPECT_EQ(cloud->width, 17);
  EXPECT_FLOAT_EQ(PointAt(*cloud, 16)[2], 2);
  std::vector<std::uint16_t> by_columns(17 * 2, 100);
  by_columns[1] = 300;  // row 1, column 0
  const auto turned = ParseDepthImage(Npy("<u2", "(2, 17)", by_columns, "True"), "a.npy", kCamera);
  ASSERT_TRUE(turned.ok()) << turned.status();
  EXPECT_FLOAT_EQ(PointAt(*turned, 17)[2], 0.3F);
  EXPECT_FALSE(IsDepthImage(Npy("<f4", "(2, 4)", std::vector<float>(8))));
  EXPECT_FALSE(IsDepthImage("VERSION 0.7"));
}

TEST(DepthImage, WhatIsNoneIsRefusedByWhatItIs) {
  const auto colours = ParseDepthImage(Png(2, 1, 8, {1, 2}), "a.png", kCamera);
  EXPECT_THAT(std::string(colours.status().message()), HasSubstr("must be a depth image"));
  const auto short_array =
      ParseDepthImage(Npy("<f4", "(2, 17)", std::vector<float>(33)), "a.npy", kCamera);
  EXPECT_THAT(std::string(short_array.status().message()),
              HasSubstr("must be what the data holds"));
  const auto huge = ParseDepthImage(Npy("<f4", "(4294967296, 4294967296)", std::vector<float>(1)),
                                    "a.npy", kCamera);
  EXPECT_FALSE(huge.ok());
  const std::string png = Png(40, 30, 16, std::vector<std::uint16_t>(1200, 700));
  for (std::size_t size = 8; size + 1 < png.size(); ++size) {
    std::string damaged = png.substr(0, size);
    const auto cut = ParseDepthImage(damaged, "a.png", kCamera);
    EXPECT_TRUE(cut.ok() || cut.status().message().find("is damaged") != std::string::npos);
    damaged = png;
    damaged[size] = static_cast<char>(damaged[size] ^ 0x55);
    static_cast<void>(ParseDepthImage(damaged, "a.png", kCamera));
  }
}

TEST(DepthImage, IsReadAsItIsSent) {
  const auto png = ReadDepthImage(Png(2, 1, 16, {1000, 65535}), "a.png");
  ASSERT_TRUE(png.ok()) << png.status();
  EXPECT_EQ(png->type, Scalar::kU16);
  EXPECT_EQ(png->unit_m, 0.001);
  EXPECT_EQ(png->bytes, std::string("\xe8\x03\xff\xff", 4));  // 1000 is 0x03e8
  const std::vector<double> depths(17, 0.5);
  const auto npy = ReadDepthImage(Npy("<f8", "(1, 17)", depths), "a.npy");
  ASSERT_TRUE(npy.ok()) << npy.status();
  EXPECT_EQ(npy->type, Scalar::kF32);
  EXPECT_EQ(npy->unit_m, 1);
  EXPECT_EQ(npy->bytes.size(), 17 * sizeof(float));
  EXPECT_EQ(ToDouble(npy->bytes.data(), Scalar::kF32), 0.5);
  const auto wide = ReadDepthImage(Npy("<i4", "(1, 17)", std::vector<int>(17, 70'000)), "a.npy");
  ASSERT_TRUE(wide.ok()) << wide.status();
  EXPECT_EQ(wide->type, Scalar::kF32);
  EXPECT_EQ(wide->unit_m, 0.001);
  EXPECT_EQ(ToDouble(wide->bytes.data(), Scalar::kF32), 70'000);
}

TEST(DepthCamera, FilesOfManyProgramsAreRead) {
  for (
      const char* text :
      {R"({"fx": 600, "fy": 610, "cx": 320, "cy": 240, "depth_scale_m": 0.001})",
       R"({"fx": 600, "fy": 610, "cx": 320, "cy": 240, "depth_unit_m": 0.001})",
       R"({"fx": 600, "fy": 610, "ppx": 320, "ppy": 240, "depth_scale": 0.001})",
       "K: [600, 0, 320, 0, 610, 240, 0, 0, 1]\ndepth_scale: 0.001\n",
       "camera_matrix:\n  rows: 3\n  cols: 3\n  data: [600, 0, 320, 0, 610, 240, 0, 0, 1]\n"
       "depth_scale: 0.001\n",
       R"({"width": 640, "intrinsic_matrix": [600,0,0, 0,610,0, 320,240,1], "depth_scale": 0.001})"}) {
    const auto camera = ParseDepthCamera(text, "camera.json");
    ASSERT_TRUE(camera.ok()) << text << camera.status();
    EXPECT_EQ(camera->fx_px, 600);
    EXPECT_EQ(camera->fy_px, 610);
    EXPECT_EQ(camera->cx_px, 320);
    EXPECT_EQ(camera->cy_px, 240);
    EXPECT_EQ(camera->unit_m, 0.001);
  }
}

TEST(DepthCamera, FactsOfTheSensorAreRead) {
  const auto camera = ParseDepthCamera(
      R"({"fx": 1, "fy": 1, "cx": 0, "cy": 0, "sensor_model": "kinect", "min_range_m": 0.4,
          "max_range_m": 4})",
      "c.json");
  ASSERT_TRUE(camera.ok()) << camera.status();
  EXPECT_EQ(camera->sensor_model, "kinect");
  EXPECT_EQ(camera->min_range_m, 0.4);
  EXPECT_EQ(camera->max_range_m, 4);
  const auto given = ParseDepthCamera(
      R"({"fx": 1, "fy": 1, "cx": 0, "cy": 0, "sensor_model": "given", "sigma_m": 0.002})",
      "c.json");
  EXPECT_EQ(given->sensor_model, "0.002");
  EXPECT_THAT(
      std::string(
          ParseDepthCamera(R"({"fx": 1, "fy": 1, "cx": 0, "cy": 0, "min_range_m": -1})", "c.json")
              .status()
              .message()),
      HasSubstr("min_range_m is -1, must be positive"));
}

TEST(DepthCamera, NineNumbersAloneAreTheMatrix) {
  const auto camera = ParseDepthCamera("5.85e+02 0 320\n0 585 240\n0 0 1\n", "k.txt");
  ASSERT_TRUE(camera.ok()) << camera.status();
  EXPECT_EQ(camera->fx_px, 585);
  EXPECT_EQ(camera->fy_px, 585);
  EXPECT_EQ(camera->cx_px, 320);
  EXPECT_EQ(camera->cy_px, 240);
  EXPECT_EQ(camera->unit_m, std::nullopt);
  for (const char* text :
       {"585 0 320 0 -585 240 0 0 1", "585 0 nan 0 585 240 0 0 1", "585 0 0 0 585 0 320 240 1"}) {
    EXPECT_THAT(std::string(ParseDepthCamera(text, "k.txt").status().message()),
                HasSubstr("k.txt: the matrix"));
  }
}

TEST(DepthCamera, WhatIsMissingOrWrongIsNamed) {
  const auto message = [](const char* text) {
    return std::string(ParseDepthCamera(text, "c.json").status().message());
  };
  EXPECT_THAT(message("{\"fx\": 600}"), HasSubstr("fy is missing"));
  EXPECT_THAT(message("{\"fx\": 0, \"fy\": 1, \"cx\": 0, \"cy\": 0}"),
              HasSubstr("must be positive"));
  EXPECT_THAT(message("{\"fx\": \"a\", \"fy\": 1, \"cx\": 0, \"cy\": 0}"), HasSubstr("fx"));
  EXPECT_THAT(message("[1, 2"), HasSubstr("is no JSON or YAML"));
  EXPECT_THAT(message("{\"fx\":1,\"fy\":1,\"cx\":0,\"cy\":0,\"depth_scale\":-1}"),
              HasSubstr("must be positive"));
}

}  // namespace
}  // namespace cwm::formats
