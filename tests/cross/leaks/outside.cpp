// A function that someone else may call by a name that does not say which instruction set it needs.
namespace handhold {
float half(float x) {
  return x / 2;
}
}  // namespace handhold
