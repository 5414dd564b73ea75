// SPDX-License-Identifier: Apache-2.0
// Classes of numbers 0 .. n - 1: parent[i] = i at first, each by itself.
#ifndef KERNEL_UNION_FIND_H
#define KERNEL_UNION_FIND_H

// What stands for the class of i: equal for all of one class. Shortens the way for those who ask later.
static inline int kn_class_root(int *parent, int i)
{
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
}

// One class of both; the lower one of their roots stands for it, so that the lowest number of a class does.
static inline void kn_class_unite(int *parent, int a, int b)
{
    int x = kn_class_root(parent, a), y = kn_class_root(parent, b);
    parent[x > y ? x : y] = x > y ? y : x;
}

#endif
