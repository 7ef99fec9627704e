"""Generated levels: what their walls are made of (mesh, texture), how they are written (gltf), and one
module for each place. Everything is a function of constants and fixed seeds."""
