#include "png.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// CRC-32 of PNG (ISO 3309), bit by bit: textures of tests are small.
static uint32_t crc32(const uint8_t *bytes, size_t size)
{
    uint32_t crc = 0xffffffffu;
    for (size_t i = 0; i < size; i++) {
        crc ^= bytes[i];
        for (int bit = 0; bit < 8; bit++)
            crc = crc & 1 ? 0xedb88320u ^ (crc >> 1) : crc >> 1;
    }
    return ~crc;
}

static void put_u32(uint8_t *out, uint32_t value)
{
    for (int i = 0; i < 4; i++)
        out[i] = (uint8_t)(value >> (24 - 8 * i));
}

// Writes one chunk: size, name, data, checksum of name and data.
static void write_chunk(FILE *file, const char *name, const uint8_t *data, size_t size)
{
    uint8_t number[4];
    uint8_t *body = malloc(size + 4);
    if (body == NULL)
        return;
    memcpy(body, name, 4);
    if (size > 0)
        memcpy(body + 4, data, size);
    put_u32(number, (uint32_t)size);
    fwrite(number, 1, 4, file);
    fwrite(body, 1, size + 4, file);
    put_u32(number, crc32(body, size + 4));
    fwrite(number, 1, 4, file);
    free(body);
}

// Wraps the rows in a zlib stream, one stored block each (RFC 1950 and 1951).
static size_t wrap_rows(uint8_t *out, const uint8_t *rgba, uint32_t width, uint32_t height)
{
    uint32_t a = 1; // the two halves of Adler-32
    uint32_t b = 0;
    const size_t row_size = 4 * (size_t)width + 1;
    uint8_t *at = out;
    *at++ = 0x78;
    *at++ = 0x01;
    for (uint32_t y = 0; y < height; y++) {
        *at++ = y + 1 == height; // the last block says so
        *at++ = (uint8_t)row_size;
        *at++ = (uint8_t)(row_size >> 8);
        *at++ = (uint8_t)~row_size;
        *at++ = (uint8_t)(~row_size >> 8);
        *at = 0; // this row is not filtered
        memcpy(at + 1, rgba + (size_t)y * width * 4, row_size - 1);
        for (size_t i = 0; i < row_size; i++) {
            a = (a + at[i]) % 65521;
            b = (b + a) % 65521;
        }
        at += row_size;
    }
    put_u32(at, b << 16 | a);
    return (size_t)(at + 4 - out);
}

uint8_t *png_encode(size_t *size, const uint8_t *rgba, uint32_t width, uint32_t height)
{
    char *bytes = NULL;
    uint8_t *stream = malloc(((size_t)width * 4 + 6) * height + 6);
    FILE *file = open_memstream(&bytes, size);
    if (stream != NULL && file != NULL) {
        uint8_t header[13] = {0};
        put_u32(header, width);
        put_u32(header + 4, height);
        header[8] = 8; // bits
        header[9] = 6; // RGBA
        fwrite("\x89PNG\r\n\x1a\n", 1, 8, file);
        write_chunk(file, "IHDR", header, sizeof(header));
        write_chunk(file, "IDAT", stream, wrap_rows(stream, rgba, width, height));
        write_chunk(file, "IEND", NULL, 0);
    }
    if (file != NULL)
        fclose(file);
    free(stream);
    return (uint8_t *)bytes;
}
