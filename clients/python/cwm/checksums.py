"""CRC-32C (Castagnoli) of upload chunks: reflected polynomial 0x82F63B78, RFC 3720 appendix B.4.

A checksum is linear over the bits, so that a megabyte is cut into lanes which advance side by side
as numpy columns, and whose remainders are then merged in pairs, halving their number each time.
"""

from __future__ import annotations

import functools

import numpy as np

_POLYNOMIAL = 0x82F63B78
_ALL_ONES = 0xFFFFFFFF
_LANE_BYTES = 256
# For shorter data the columns are too short for numpy.
_VECTOR_BYTES = 4096


@functools.lru_cache(maxsize=1)
def _byte_table() -> np.ndarray:
    """What each byte leaves behind, (256,) uint32."""
    table = np.arange(256, dtype=np.uint32)
    for _ in range(8):
        table = np.where(table & 1, (table >> 1) ^ np.uint32(_POLYNOMIAL), table >> 1)
    return table


@functools.lru_cache(maxsize=1)
def _byte_list() -> list[int]:
    return _byte_table().tolist()


@functools.lru_cache(maxsize=1)
def _word_table() -> np.ndarray:
    """What two bytes at once, little-endian, leave behind, (65536,) uint32."""
    words = np.arange(1 << 16, dtype=np.uint32)
    table = _byte_table()
    half = table[words & 0xFF] ^ (words >> 8)
    return table[half & 0xFF] ^ (half >> 8)


@functools.lru_cache(maxsize=64)
def _zeros_tables(byte_count: int) -> tuple[np.ndarray, np.ndarray]:
    """What a remainder becomes after so many zero bytes, by its low and its high 16 bits. A
    power of two, at least 2.
    """
    if byte_count == 2:
        low = _word_table()
        return low, np.arange(1 << 16, dtype=np.uint32)
    half = byte_count // 2
    words = np.arange(1 << 16, dtype=np.uint32)
    return tuple(_after_zeros(_after_zeros(part, half), half) for part in (words, words << 16))


def _after_zeros(remainders: np.ndarray, byte_count: int) -> np.ndarray:
    low, high = _zeros_tables(byte_count)
    return low[remainders & 0xFFFF] ^ high[remainders >> 16]


def _small(remainder: int, data: bytes | memoryview) -> int:
    table = _byte_list()
    for byte in data:
        remainder = table[(remainder ^ byte) & 0xFF] ^ (remainder >> 8)
    return remainder


def crc32c(data: bytes | memoryview) -> int:
    """The checksum of the bytes."""
    if len(data) < _VECTOR_BYTES:
        return _small(_ALL_ONES, bytes(data)) ^ _ALL_ONES
    lanes = 1 << ((len(data) - 1) // _LANE_BYTES).bit_length()
    # Leading zeros do not change the remainder; inverting the first four bytes is equivalent to the
    # initial value of all ones.
    padded = np.zeros(lanes * _LANE_BYTES, dtype=np.uint8)
    begin = padded.size - len(data)
    padded[begin:] = np.frombuffer(data, dtype=np.uint8)
    padded[begin : begin + 4] ^= 0xFF
    columns = np.ascontiguousarray(padded.view("<u2").reshape(lanes, _LANE_BYTES // 2).T)
    table = _word_table()
    remainders = np.zeros(lanes, dtype=np.uint32)
    for column in columns:
        remainders = table[(remainders ^ column) & 0xFFFF] ^ (remainders >> 16)
    length = _LANE_BYTES
    while remainders.size > 1:
        remainders = _after_zeros(remainders[0::2], length) ^ remainders[1::2]
        length *= 2
    return int(remainders[0]) ^ _ALL_ONES
