// SPDX-License-Identifier: BSD-3-Clause
// No include guard: software_painter.cc includes this once for each set of instructions, each time
// in a namespace of its own. Every operation is one that IEEE 754 defines, in the same order in
// each of them, so all find the same bits.

using F8 = float __attribute__((vector_size(32)));
using I8 = std::int32_t __attribute__((vector_size(32)));
using U8 = std::uint32_t __attribute__((vector_size(32)));
using B8 = std::uint8_t __attribute__((vector_size(8)));
using B16 = std::uint8_t __attribute__((vector_size(16)));
using H8 = std::uint16_t __attribute__((vector_size(16)));
using H16 = std::uint16_t __attribute__((vector_size(32)));

constexpr I8 kLanes_i{0, 1, 2, 3, 4, 5, 6, 7};
constexpr F8 kLanes{0, 1, 2, 3, 4, 5, 6, 7};

inline F8 all(float value) { return F8{} + value; }

/// Of a comparison: a bit for each lane.
inline unsigned bits(const I8& mask) {
#ifdef PANOPTES_AVX2_KERNEL
  return static_cast<unsigned>(_mm256_movemask_ps(reinterpret_cast<__m256>(mask)));
#else
  unsigned out = 0;
  for (int i = 0; i < 8; ++i) {
    out |= (static_cast<std::uint32_t>(mask[i]) >> 31U) << static_cast<unsigned>(i);
  }
  return out;
#endif
}

/// The 32-bit words at each place.
inline I8 gather(const std::uint32_t* base, const I8& at) {
#ifdef PANOPTES_AVX2_KERNEL
  return reinterpret_cast<I8>(
      _mm256_i32gather_epi32(reinterpret_cast<const int*>(base), reinterpret_cast<__m256i>(at), 4));
#else
  I8 words;
  for (int i = 0; i < 8; ++i) {
    words[i] = static_cast<std::int32_t>(base[at[i]]);
  }
  return words;
#endif
}

/// Two words next to one another at each of eight places: those of lanes 0, 1, 4, 5 and of lanes
/// 2, 3, 6, 7.
struct Pairs {
  H16 first;
  H16 second;
};

inline Pairs gather_pairs(const std::uint32_t* base, const I8& at) {
#ifdef PANOPTES_AVX2_KERNEL
  const auto* words = reinterpret_cast<const long long*>(base);
  const auto lanes = [&at](auto order) {
    return _mm256_castsi256_si128(
        _mm256_permute4x64_epi64(reinterpret_cast<__m256i>(at), decltype(order)::value));
  };
  return {reinterpret_cast<H16>(
              _mm256_i32gather_epi64(words, lanes(std::integral_constant<int, 0x08>()), 4)),
          reinterpret_cast<H16>(
              _mm256_i32gather_epi64(words, lanes(std::integral_constant<int, 0x0D>()), 4))};
#else
  const auto lanes = [&](int a, int b, int c, int d) {
    U8 words{base[at[a]], base[at[a] + 1], base[at[b]], base[at[b] + 1],
             base[at[c]], base[at[c] + 1], base[at[d]], base[at[d] + 1]};
    return reinterpret_cast<H16>(words);
  };
  return {lanes(0, 1, 4, 5), lanes(2, 3, 6, 7)};
#endif
}

/// At eight pixels of one row (Dy is float), or at any eight (F8).
template <typename Dy>
inline F8 at_lanes(const Plane3& plane, const F8& dx_px, const Dy& dy_px) {
  return (plane.at_origin + plane.per_y * dy_px) + plane.per_x * dx_px;
}

/// Each value as its whole part, towards minus infinity, and 256ths above it.
inline I8 split(const F8& value, I8& part) {
  I8 whole = __builtin_convertvector(value, I8);
  whole += value < __builtin_convertvector(whole, F8);  // true is -1
  part = __builtin_convertvector((value - __builtin_convertvector(whole, F8)) * 256.0F, I8);
  return whole;
}

/// Between bytes of a and b, `part` 256ths from a to b.
inline H16 blend(const H16& a, const H16& b, const H16& part) {
  const H16 rest = 256 - part;
  const H16 even = ((a & 255) * rest + (b & 255) * part + 128) >> 8;
  const H16 odd = ((a >> 8) * rest + (b >> 8) * part + 128) & 0xFF00;
  return even | odd;
}

/// The same number in both halves of each word.
inline U8 in_both_halves(const I8& part) { return reinterpret_cast<U8>(part | part << 16); }

/// Where eight pixels of one triangle sample texture and lightmap.
struct Samples {
  I8 upper;  ///< words of the pool: the left one of two texels
  I8 lower;
  I8 part_u;  ///< 256ths from the left texel to the right
  I8 part_v;
  I8 light;  ///< a word of the lightmap
  I8 light_part_u;
  I8 light_part_v;
};

/// The four texels around each sample, in the level of detail whose texels are nearest to a pixel's
/// size.
inline void find_texels(const PaintedTexture& texture, const F8& u_px, const F8& v_px,
                        const F8& footprint_px2, Samples& out) {
  // Half the logarithm of the footprint's square, rounded: its exponent tells.
  I8 level = ((reinterpret_cast<I8>(footprint_px2) >> 23) - 126) >> 1;
  level = level > 0 ? level : I8{};
  level = level < texture.last_level ? level : I8{} + texture.last_level;
  const auto scale = reinterpret_cast<F8>((127 - level) << 23);
  I8 column = split(u_px * scale - 0.5F, out.part_u);
  I8 row = split(v_px * scale - 0.5F, out.part_v);
  const I8 mask_v = (I8{} + (texture.height_px - 1)) >> level;
  I8 shift = texture.width_log2 - level;
  shift = shift > 0 ? shift : I8{};
  column &= (I8{} + (texture.width_px - 1)) >> level;
  const I8 next = (row + 1) & mask_v;
  row &= mask_v;
  const I8 base = gather(texture.level_at.data(), level);
  out.upper = (row << shift) + row + column + base;
  out.lower = (next << shift) + next + column + base;
}

inline void find_light(const PaintedLight& lightmap, const F8& column, const F8& row,
                       Samples& out) {
  const auto inside = [](const F8& value, float most) {
    const F8 high = value > 0 ? value : F8{};  // nothing, where it is not a number
    return high < most ? high : all(most);
  };
  const I8 left = split(inside(column, lightmap.last_column), out.light_part_u);
  out.light = split(inside(row, lightmap.last_row), out.light_part_v) * lightmap.columns + left;
}

/// `detail_px2` is how much of the picture one sample is to cover.
template <typename Dy, typename Detail>
inline Samples find_samples(const Shade& t, const Paint& paint, const F8& dx_px, const Dy& dy_px,
                            const F8& distance, const Detail& detail_px2) {
  const F8 u = at_lanes(t.u, dx_px, dy_px) * distance;
  const F8 v = at_lanes(t.v, dx_px, dy_px) * distance;
  const F8 u_x = (t.u.per_x - u * t.inverse_depth.per_x) * distance;
  const F8 v_x = (t.v.per_x - v * t.inverse_depth.per_x) * distance;
  const F8 u_y = (t.u.per_y - u * t.inverse_depth.per_y) * distance;
  const F8 v_y = (t.v.per_y - v * t.inverse_depth.per_y) * distance;
  const F8 across = u_x * u_x + v_x * v_x;
  const F8 down = u_y * u_y + v_y * v_y;
  Samples samples;
  find_texels(paint.textures[t.texture], u, v, (across > down ? across : down) * detail_px2,
              samples);
  find_light(paint.light, at_lanes(t.column, dx_px, dy_px) * distance,
             at_lanes(t.row, dx_px, dy_px) * distance, samples);
  return samples;
}

inline U8 texels(const std::uint32_t* pool, const Samples& at) {
  const Pairs top = gather_pairs(pool, at.upper);
  const Pairs bottom = gather_pairs(pool, at.lower);
  const U8 down = in_both_halves(at.part_v);
  const auto first = reinterpret_cast<U8>(
      blend(top.first, bottom.first,
            reinterpret_cast<H16>(__builtin_shufflevector(down, down, 0, 0, 1, 1, 4, 4, 5, 5))));
  const auto second = reinterpret_cast<U8>(
      blend(top.second, bottom.second,
            reinterpret_cast<H16>(__builtin_shufflevector(down, down, 2, 2, 3, 3, 6, 6, 7, 7))));
  const U8 left = __builtin_shufflevector(first, second, 0, 2, 8, 10, 4, 6, 12, 14);
  const U8 right = __builtin_shufflevector(first, second, 1, 3, 9, 11, 5, 7, 13, 15);
  return reinterpret_cast<U8>(blend(reinterpret_cast<H16>(left), reinterpret_cast<H16>(right),
                                    reinterpret_cast<H16>(in_both_halves(at.part_u))));
}

/// 255 * 2^16 times the lightmap's value.
inline F8 light(const std::uint32_t* fours, const Samples& at) {
  const I8 four = gather(fours, at.light);
  const auto part = reinterpret_cast<H16>(in_both_halves(at.light_part_u));
  const auto left = reinterpret_cast<H16>(four & 0x00FF00FF);
  const auto right = reinterpret_cast<H16>(four >> 8 & 0x00FF00FF);
  const auto rows = reinterpret_cast<I8>(left * (256 - part) + right * part);  // upper, lower
  return __builtin_convertvector(rows & 0xFFFF, F8) *
             __builtin_convertvector(256 - at.light_part_v, F8) +
         __builtin_convertvector((rows >> 16) & 0xFFFF, F8) *
             __builtin_convertvector(at.light_part_v, F8);
}

inline U8 lit_texels(const Paint& paint, const Samples& at) {
  const U8 texture = texels(paint.pool, at);
  const F8 illumination = light(paint.light.fours, at) * paint.gain;
  const auto channel = [&](int shift) {
    const F8 value =
        __builtin_convertvector(reinterpret_cast<I8>((texture >> shift) & 255), F8) * illumination +
        0.5F;
    return reinterpret_cast<U8>(__builtin_convertvector(value < 255.0F ? value : all(255), I8))
           << shift;
  };
  return channel(0) | channel(8) | channel(16);
}

/// Puts a triangle into a tile: where it is nearer than what is there, its number and how near.
inline void raster_tile(const Covered& t, const std::array<std::int64_t, 3>& edges, bool whole,
                        float near_at_tile, float* inverse_depth, std::uint32_t* numbers,
                        float& farthest) {
  std::array<I8, 3> inside{};
  std::array<I8, 3> down{};
  if (!whole) {
    for (std::size_t i = 0; i < 3; ++i) {
      // An edge that does not cross the tile may be too far to count in 32 bits.
      const std::int64_t e = std::clamp<std::int64_t>(edges[i], -kFarEdge, kFarEdge);
      const bool crosses = e == edges[i];
      inside[i] = static_cast<std::int32_t>(e) - (crosses ? t.edges[i].dy : 0) * kLanes_i;
      down[i] = I8{} + (crosses ? t.edges[i].dx : 0);
    }
  }
  const F8 along = t.inverse_depth.per_x * kLanes;
  const U8 number = U8{} + t.number;
  F8 least = all(std::numeric_limits<float>::infinity());
  bool changed = false;
  for (int row = 0; row < kTile; ++row) {
    const F8 z = (near_at_tile + t.inverse_depth.per_y * static_cast<float>(row)) + along;
    auto* stored = reinterpret_cast<F8*>(inverse_depth + first_of(0, row));
    I8 nearer = z > *stored;
    if (!whole) {
      nearer &= ~((inside[0] | inside[1] | inside[2]) >> 31);
      for (std::size_t i = 0; i < 3; ++i) {
        inside[i] += down[i];
      }
    }
    if (bits(nearer) != 0) {
      changed = true;
      *stored = nearer ? z : *stored;
      auto* of = reinterpret_cast<U8*>(numbers + first_of(0, row));
      *of = nearer ? number : *of;
    }
    least = *stored < least ? *stored : least;
  }
  if (changed) {
    farthest = least[0];
    for (int i = 1; i < 8; ++i) {
      farthest = std::min(farthest, least[i]);
    }
  }
}

/// The nearest triangle at each pixel of a row of tiles.
void raster_row(const std::vector<Covered>& triangles, const std::vector<std::uint32_t>& row_of,
                int tile_row, int columns, TileRow& tiles) {
  std::fill(tiles.inverse_depth.begin(), tiles.inverse_depth.end(), 0.0F);
  std::fill_n(tiles.numbers, tiles.inverse_depth.size(), kNothing);
  std::fill(tiles.farthest.begin(), tiles.farthest.end(), 0.0F);
  const int y = tile_row * kTile;
  for (const std::uint32_t k : row_of) {
    const Covered& t = triangles[k];
    const int x = t.first_column * kTile;
    std::array<std::int64_t, 3> edge;
    std::array<std::int64_t, 3> most;  // over a tile, above its first pixel's
    std::array<std::int64_t, 3> least;
    for (std::size_t i = 0; i < 3; ++i) {
      const Edge& e = t.edges[i];
      edge[i] = e.at_origin + std::int64_t{e.dx} * y - std::int64_t{e.dy} * x;
      const std::int64_t across = std::int64_t{-(kTile - 1)} * e.dy;
      const std::int64_t down = std::int64_t{kTile - 1} * e.dx;
      most[i] = std::max<std::int64_t>(across, 0) + std::max<std::int64_t>(down, 0);
      least[i] = std::min<std::int64_t>(across, 0) + std::min<std::int64_t>(down, 0);
    }
    const float near_at_row =
        t.inverse_depth.at_origin + t.inverse_depth.per_y * static_cast<float>(y - t.origin_y_px);
    const float steps = static_cast<float>(kTile - 1);
    const float nearest_in_tile = std::max(t.inverse_depth.per_y * steps, 0.0F);
    const float nearest_across = std::max(t.inverse_depth.per_x * steps, 0.0F);
    for (int column = t.first_column; column <= t.last_column && column < columns; ++column) {
      const bool outside = edge[0] + most[0] < 0 || edge[1] + most[1] < 0 || edge[2] + most[2] < 0;
      if (!outside) {
        const float near_at_tile =
            near_at_row +
            t.inverse_depth.per_x * static_cast<float>(column * kTile - t.origin_x_px);
        const auto c = static_cast<std::size_t>(column);
        if (std::min((near_at_tile + nearest_in_tile) + nearest_across, t.nearest) >
            tiles.farthest[c]) {
          const bool whole =
              edge[0] + least[0] >= 0 && edge[1] + least[1] >= 0 && edge[2] + least[2] >= 0;
          raster_tile(t, edge, whole, near_at_tile, &tiles.inverse_depth[first_of(column, 0)],
                      &tiles.numbers[first_of(column, 0)], tiles.farthest[c]);
        }
      }
      for (std::size_t i = 0; i < 3; ++i) {
        edge[i] -= std::int64_t{t.edges[i].dy} * kTile;
      }
    }
  }
}

/// What eight pixels truly show.
struct Truth {
  I8 objects{};
  I8 floor{};  ///< -1 where it is
};

/// The part of it that is one triangle's.
template <typename Dy>
inline void add_truth(const Shade& t, const I8& mine, const F8& dx_px, const Dy& dy_px,
                      Truth& truth) {
  truth.objects |= mine & t.object;
  truth.floor |= mine & (at_lanes(t.above_floor_m, dx_px, dy_px) < 0.0F);
}

inline void store(const Truth& truth, const F8& distance_m, std::size_t to, const PixelRows& out) {
  const H8 objects = __builtin_convertvector(truth.objects, H8);
  const auto bytes = reinterpret_cast<B16>(__builtin_convertvector(truth.floor, H8));
  const B8 floor = __builtin_shufflevector(bytes, bytes, 0, 2, 4, 6, 8, 10, 12, 14);
  std::memcpy(&out.depth_m[to], &distance_m, sizeof distance_m);
  std::memcpy(&out.instance[to], &objects, sizeof objects);
  std::memcpy(&out.floor[to], &floor, sizeof floor);
}

/// Some of eight pixels that show one triangle.
struct Part {
  Samples samples;
  U8 mask;
  std::uint32_t* bgra;  ///< of the first of the eight
};

inline void shade(const Paint& paint, const Part& part) {
  U8 bgra;
  std::memcpy(&bgra, part.bgra, sizeof bgra);
  bgra = (lit_texels(paint, part.samples) & part.mask) | (bgra & ~part.mask);
  std::memcpy(part.bgra, &bgra, sizeof bgra);
}

/// The pixels of a row of tiles, each triangle shaded once where it is seen. First all samples of a
/// tile are found, then all are looked up, so that many waits for memory pass at once.
template <bool kWithTruth>
inline void shade_tiles(const std::vector<Shade>& triangles, const Paint& paint,
                        const TileRow& tiles, int tile_row, int columns, int rows_px,
                        const PixelRows& out) {
  std::array<Part, kPixelsOfTile> parts;
  std::fill_n(out.bgra, pixel_of(0, rows_px, columns), paint.sky);
  for (int column = 0; column < columns; ++column) {
    std::size_t count = 0;
    for (int row = 0; row < rows_px; ++row) {
      const std::size_t at = first_of(column, row);
      const std::size_t to = pixel_of(column, row, columns);
      const auto& numbers = *reinterpret_cast<const U8*>(&tiles.numbers[at]);
      Truth truth;
      unsigned left = bits(reinterpret_cast<I8>(numbers != kNothing));
      while (left != 0) {
        const std::uint32_t number =
            tiles.numbers[at + static_cast<std::size_t>(std::countr_zero(left))];
        const Shade& t = triangles[number];
        const F8 dx_px = static_cast<float>(column * kTile - t.origin_x_px) + kLanes;
        const auto dy_px = static_cast<float>(tile_row * kTile + row - t.origin_y_px);
        const F8 distance = 1.0F / at_lanes(t.inverse_depth, dx_px, dy_px);
        const auto mine = reinterpret_cast<I8>(numbers == number);
        parts[count++] = {find_samples(t, paint, dx_px, dy_px, distance, 1.0F),
                          reinterpret_cast<U8>(mine), &out.bgra[to]};
        left &= ~bits(mine);
        if constexpr (kWithTruth) {
          add_truth(t, mine, dx_px, dy_px, truth);
        }
      }
      if constexpr (kWithTruth) {
        // Where nothing is it is infinite.
        const F8 distance_m = 1.0F / *reinterpret_cast<const F8*>(&tiles.inverse_depth[at]);
        store(truth, distance_m, to, out);
      }
    }
    for (std::size_t i = 0; i < count; ++i) {
      shade(paint, parts[i]);
    }
  }
}

void shade_row(const std::vector<Shade>& triangles, const Paint& paint, const TileRow& tiles,
               bool with_truth, int tile_row, int columns, int rows_px, const PixelRows& out) {
  if (with_truth) {
    shade_tiles<true>(triangles, paint, tiles, tile_row, columns, rows_px, out);
  } else {
    shade_tiles<false>(triangles, paint, tiles, tile_row, columns, rows_px, out);
  }
}

/// As shade_row, of a picture that samples a canvas through a remap table: each pixel shows the
/// triangle at the pixel of the canvas nearest to its sample, as it is at the sample itself; beyond
/// the triangle's sides, as it is at the canvas's pixel.
template <bool kWithTruth>
inline void remap_tiles(const std::vector<Shade>& triangles, const Paint& paint,
                        const Canvas& canvas, const RemapTable& remap, int columns, int rows_px,
                        const PixelRows& out) {
  std::array<Part, kPixelsOfTile> parts;
  std::fill_n(out.bgra, pixel_of(0, rows_px, columns), paint.sky);
  for (int column = 0; column < columns; ++column) {
    std::size_t count = 0;
    for (int row = 0; row < rows_px; ++row) {
      const std::size_t to = pixel_of(column, row, columns);
      F8 x_px;
      F8 y_px;
      F8 detail_px2;
      __builtin_prefetch(&remap.x_px[to + 24]);
      __builtin_prefetch(&remap.y_px[to + 24]);
      __builtin_prefetch(&remap.detail_px2[to + 24]);
      std::memcpy(&x_px, &remap.x_px[to], sizeof x_px);
      std::memcpy(&y_px, &remap.y_px[to], sizeof y_px);
      std::memcpy(&detail_px2, &remap.detail_px2[to], sizeof detail_px2);
      const I8 x = __builtin_convertvector(x_px + 0.5F, I8);
      const I8 y = __builtin_convertvector(y_px + 0.5F, I8);
      const I8 tile = (y >> kTileLog2) * canvas.columns + (x >> kTileLog2);
      const I8 in_tile = ((y & (kTile - 1)) << kTileLog2) + (x & (kTile - 1));
      const auto numbers =
          reinterpret_cast<U8>(gather(canvas.numbers, (tile << (2 * kTileLog2)) + in_tile));
      Truth truth;
      F8 distance_m = all(std::numeric_limits<float>::infinity());
      unsigned left = bits(reinterpret_cast<I8>(numbers != kNothing));
      while (left != 0) {
        const std::uint32_t number = numbers[std::countr_zero(left)];
        const Shade& t = triangles[number];
        F8 dx_px = x_px - static_cast<float>(t.origin_x_px);
        F8 dy_px = y_px - static_cast<float>(t.origin_y_px);
        I8 outside{};
        for (const Plane3& side : t.sides) {
          outside |= reinterpret_cast<I8>(at_lanes(side, dx_px, dy_px));
        }
        if (bits(outside) != 0) {  // the signs
          const I8 moved = outside < 0;
          dx_px = moved ? __builtin_convertvector(x - t.origin_x_px, F8) : dx_px;
          dy_px = moved ? __builtin_convertvector(y - t.origin_y_px, F8) : dy_px;
        }
        const F8 distance = 1.0F / at_lanes(t.inverse_depth, dx_px, dy_px);
        const auto mine = reinterpret_cast<I8>(numbers == number);
        parts[count++] = {find_samples(t, paint, dx_px, dy_px, distance, detail_px2),
                          reinterpret_cast<U8>(mine), &out.bgra[to]};
        left &= ~bits(mine);
        if constexpr (kWithTruth) {
          add_truth(t, mine, dx_px, dy_px, truth);
          distance_m = mine ? distance : distance_m;
        }
      }
      if constexpr (kWithTruth) {
        store(truth, distance_m, to, out);
      }
    }
    for (std::size_t i = 0; i < count; ++i) {
      shade(paint, parts[i]);
    }
  }
}

void remap_row(const std::vector<Shade>& triangles, const Paint& paint, const Canvas& canvas,
               const RemapTable& remap, bool with_truth, int columns, int rows_px,
               const PixelRows& out) {
  if (with_truth) {
    remap_tiles<true>(triangles, paint, canvas, remap, columns, rows_px, out);
  } else {
    remap_tiles<false>(triangles, paint, canvas, remap, columns, rows_px, out);
  }
}
